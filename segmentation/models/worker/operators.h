#pragma once

#include <set>
#include <string>

namespace pliant {

/// Operators that source code of TorchScript calls: "aten::roll" for torch.roll(...), "vision::nms" for
/// ops.vision.nms(...).
std::set<std::string> operators_in(const std::string& code);

/// The operator that a message of libtorch about a failed load complains about, with its namespace; empty where there
/// is none.
std::string operator_of_message(const std::string& text);

/// "the operator a" or "the operators a, b".
std::string operators_text(const std::set<std::string>& names);

}  // namespace pliant
