#include <nlohmann/json.hpp>

#include "app/commands/command.h"
#include "app/commands/option_parser.h"
#include "app/predict/predictor_training.h"

namespace pliant {

void add_train_predictor(CLI::App& app, Program& program) {
  CLI::App* command =
      app.add_subcommand("train-predictor", "Train the network that predict distributes materials with");
  auto training = std::make_shared<TrainPredictor>();
  add_options(*command, program, options_of(*training));
  add_out(*command, program, "Folder for the weights, the training curve and the metrics")->required();
  add_overwrite(*command, program, "Replace weights that exist");
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context& context) { return run_training(context, *training, program.out); };
  });
}

}  // namespace pliant
