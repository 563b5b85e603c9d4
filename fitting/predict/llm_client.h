#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "fitting/predict/material_prior.h"
#include "fitting/predict/material_table.h"

namespace pliant {

struct LlmOptions {
  std::string url;                 ///< of an OpenAI-compatible service, such as http://127.0.0.1:8000/v1; empty = off
  std::string model;               ///< name that the service knows
  std::string key;                 ///< empty = none is sent; see llm_key()
  std::filesystem::path cache;     ///< folder of earlier answers; empty = none are kept
  double timeout = 20;             ///< s
  size_t max_answer = 256 * 1024;  ///< bytes
};

/// The key for the service at `url`: the environment's PLIANT_LLM_KEY, else at https://api.openai.com/ OPENAI_API_KEY,
/// which no other service may see, else nothing; without blanks and line breaks at its end.  Throws Error{kUsage} for
/// control characters within it.
std::string llm_key(const std::string& url);

/// Lowest and highest E, nu, rho that an answer may have.
struct MaterialBounds {
  Band young, poisson, density;  ///< low and high count
};
/// Those of all materials in the classes of the moving parts; of the whole table without a match.
MaterialBounds material_bounds(const MaterialTable& table, const PriorMatch* match);

/// A label as it is sent: blanks in place of control characters, and at most 200 bytes of whole UTF-8 characters.
std::string sent_label(const std::string& label);

struct LlmMaterial {
  Band young, poisson, density;  ///< Pa, 1, kg/m^3, ordered and within the bounds
  std::string what;              ///< what the model sees, at most 80 characters
  bool clamped = false;          ///< a number was outside the bounds
  bool cached = false;
};

struct LlmAnswer {
  std::optional<LlmMaterial> material;
  std::string failure;  ///< why there is none, in words; empty when there is one or when the client is off
};

/// Asks a language model once for the material of what `label` names and `view` (a PNG; may be empty) shows: chat
/// completion with a JSON schema; once more where the model refuses max_tokens or a temperature.  The label travels as
/// data, see sent_label; whatever the answer says, only nine checked and clamped numbers and a short text are taken
/// from it.  Never throws for what the service does; answers are cached by service, model, label
/// and view.
LlmAnswer ask_llm(const LlmOptions& options, const MaterialBounds& bounds, const std::string& label,
                  const std::string& view);

}  // namespace pliant
