#include "app/run/stage_inputs.h"

namespace pliant {

void record_options(const OptionTable& table, StageKey& key) {
  key.name = table.stage;
  for (const Option& option : table.options) {
    if (option.recorded == Recorded::kValue) {
      const nlohmann::json value = field_json(option.field);
      key.options[option.name] = option.off ? nlohmann::json(!value.get<bool>()) : value;
    }
    if (option.recorded != Recorded::kContents) continue;
    const std::vector<std::string> files = field_words(option.field);
    for (size_t i = 0; i < files.size(); ++i)
      key.inputs[files.size() == 1 ? option.name : option.name + " " + std::to_string(i + 1)] = files[i];
  }
}

void take_recorded(const nlohmann::json& options, const OptionTable& table) {
  for (const Option& option : table.options) {
    if (option.recorded != Recorded::kValue || !options.contains(option.name)) continue;
    const nlohmann::json& value = options[option.name];
    set_field(option.field, option.off ? nlohmann::json(!value.get<bool>()) : value);
  }
}

}  // namespace pliant
