#pragma once

#include <cstdint>
#include <deque>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace pliant {

/// A value of a pickle.  Containers refer to values by their number in the pickle.
struct PickleValue {
  enum class Kind { kNone, kBool, kInt, kFloat, kText, kTuple, kList, kDict, kGlobal, kPersistent, kObject };
  Kind kind = Kind::kNone;
  int64_t number = 0;      ///< of kBool and kInt
  double real = 0;         ///< of kFloat
  std::string text;        ///< of kText; module and name of kGlobal, as "module name"
  std::vector<int> items;  ///< of kTuple, kList; of kPersistent its id; of kObject callable and arguments
  std::vector<std::pair<int, int>> entries;  ///< of kDict: keys and values
};

/// Values of a pickle, without any of the effects that unpickling in Python has: a global is a name, an object is what
/// is called with which arguments.
struct Pickle {
  std::deque<PickleValue> values;
  int root = -1;

  const PickleValue& operator[](int value) const { return values[value]; }
};

/// Parses a pickle of protocol 2, the one that torch.save writes, as far as state dicts need it.  Globals that are not
/// in `allowed` ("module name") and all other operations are refused before anything after them is looked at.  Throws
/// Error{kInput} naming `file` and `entry`.
Pickle parse_pickle(std::string_view bytes, const std::vector<std::string>& allowed, const std::string& file,
                    const std::string& entry);

}  // namespace pliant
