#include <filesystem>

#include "app/commands/command.h"
#include "app/commands/option_parser.h"
#include "app/demo/kinds/kinds.h"
#include "app/suite/suite.h"

namespace pliant {

void add_evaluate_suite(CLI::App& evaluate, Program& program) {
  CLI::App* command = evaluate.add_subcommand("suite", "Demo scenes x methods against the truth, by Snakemake");
  auto stage = std::make_shared<SuiteStage>();
  add_options(*command, program, options_of(*stage));
  add_out(*command, program, "Folder of the suite, made or continued")->required();
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context& context) {
      const std::string pliant = std::filesystem::read_symlink("/proc/self/exe");
      return run_suite(context, suite_settings(*stage, pliant, demo_kind_names()), *stage, program.out);
    };
  });
}

}  // namespace pliant
