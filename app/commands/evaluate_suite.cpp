#include <filesystem>

#include "app/commands/command.h"
#include "app/commands/option_parser.h"
#include "app/demo/kinds/kinds.h"
#include "app/suite/suite.h"
#include "gaussians/base/error.h"

namespace pliant {

void add_evaluate_suite(CLI::App& evaluate, Program& program) {
  CLI::App* command = evaluate.add_subcommand("suite", "Demo scenes x methods against the truth, by Snakemake");
  auto stage = std::make_shared<SuiteStage>();
  add_options(*command, program, options_of(*stage));
  add_out(*command, program, "Folder of the suite, made or continued")->required();
  add_common(*command, program);
  command->callback([=, &program] {
    program.action = [=, &program](Context& context) {
      if (command->get_option("--threads")->count() > 0)
        throw usage_error("evaluate suite", "--threads", "does nothing: each job has one thread",
                          "give --workers N, the jobs at a time");
      if (command->get_option("--seed")->count() > 0)
        throw usage_error("evaluate suite", "--seed", "does nothing: the scenes have seeds of their own",
                          "give --seeds N, the scenes of each kind");
      const std::string pliant = std::filesystem::read_symlink("/proc/self/exe");
      return run_suite(context, suite_settings(*stage, pliant, demo_kind_names()), *stage, program.out);
    };
  });
}

}  // namespace pliant
