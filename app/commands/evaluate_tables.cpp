#include "app/commands/evaluate_tables.h"

#include <fmt/format.h>

#include <cstdio>
#include <memory>
#include <nlohmann/json.hpp>

#include "app/evaluate/compare.h"
#include "app/evaluate/evaluate_calibration.h"
#include "app/evaluate/self_test.h"
#include "app/evaluate/study/study_page.h"
#include "app/evaluate/study/study_statistics.h"
#include "app/evaluate/study/study_tables.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// Prints the tables, unless JSON is wanted, and writes all forms to the folder of --out.
void give(const Program& program, const json& result, const std::vector<std::string>& arrays,
          const std::vector<TextTable>& tables) {
  if (!program.json)
    for (const TextTable& table : tables) std::printf("%s\n", markdown_of(table).c_str());
  if (!program.out.empty()) write_tables(program.out, result, arrays, tables);
}

void add_bootstrap(CLI::App& command, BootstrapOptions& options) {
  command.add_option("--level", options.level, fmt::format("Confidence level of the intervals [{}]", options.level))
      ->check(CLI::Range(0.5, 0.999))
      ->option_text("X");
  command.add_option("--resamples", options.resamples, fmt::format("Bootstrap resamples [{}]", options.resamples))
      ->check(CLI::Range(100, 10000000))
      ->option_text("N");
}

constexpr const char* kTables = "Folder for the tables as JSON, CSV and Markdown";

void add_compare(CLI::App& evaluate, Program& program) {
  CLI::App* sub = evaluate.add_subcommand("compare", "Compare one method with all others, from result files");
  struct Given {
    std::vector<std::string> methods;
    CompareOptions options;
  };
  auto given = std::make_shared<Given>();
  sub->add_option("METHODS", given->methods, "NAME=FOLDER with SCENE.json or SCENE/RUN.json; the first is ours")
      ->required()
      ->expected(2, 1000);
  repeatable(
      sub->add_option("--metric", given->options.metrics,
                      "Metric to compare, or any key as KEY:higher or KEY:lower; repeatable (default: all known)"))
      ->option_text("KEY");
  add_bootstrap(*sub, given->options.bootstrap);
  add_out(*sub, program, kTables);
  add_common(*sub, program);
  sub->callback([given, &program] {
    program.action = [given, &program](Context& context) {
      std::vector<Method> methods;
      for (const std::string& text : given->methods) {
        const size_t equals = text.find('=');
        if (equals == std::string::npos || equals == 0 || equals + 1 == text.size())
          throw usage_error("evaluate", "METHODS", "has '" + text + "'", "write NAME=FOLDER");
        methods.push_back({text.substr(0, equals), text.substr(equals + 1)});
        for (size_t i = 0; i + 1 < methods.size(); ++i)
          if (methods[i].name == methods.back().name)
            throw usage_error("evaluate", "METHODS", "has '" + methods[i].name + "' twice", "give each its own name");
      }
      given->options.bootstrap.seed = context.seed;
      json result = compare_methods(methods, given->options);
      give(program, result, {"means", "differences"}, compare_tables(result));
      return result;
    };
  });
}

void add_study(CLI::App& evaluate, Program& program) {
  CLI::App* sub = evaluate.add_subcommand("study", "Page of a user study, or the statistics of its answers");
  struct Given {
    std::string list;
    std::vector<std::string> answers;
    BootstrapOptions bootstrap;
  };
  auto given = std::make_shared<Given>();
  sub->add_option("LIST", given->list, "study.json: scenes with a clip of each method, and what is asked")->required();
  sub->add_option("--answers", given->answers,
                  "Answers that the page saved, or folders of them; repeatable: statistics instead of the page")
      ->option_text("FILE|DIR");
  add_bootstrap(*sub, given->bootstrap);
  add_out(*sub, program, "Page to write (default: study.html); with --answers a folder for the tables")
      ->option_text("FILE|DIR");
  add_common(*sub, program);
  sub->callback([given, sub, &program] {
    program.action = [given, sub, &program](Context& context) {
      const StudyList study = read_study(given->list);
      if (given->answers.empty()) {
        for (const char* name : {"--level", "--resamples"})
          if (sub->count(name)) throw usage_error("evaluate", name, "does nothing without --answers", "leave it out");
        const fs::path file = program.out.empty() ? "study.html" : program.out;
        const std::string page = study_page(study);
        write_text(file, page);
        json result = {{"kind", "study-page"}, {"study", study.id}, {"file", file.string()}, {"bytes", page.size()}};
        if (!program.json) std::printf("%s\n", result.dump(2).c_str());
        return result;
      }
      given->bootstrap.seed = context.seed;
      const std::vector<fs::path> files(given->answers.begin(), given->answers.end());
      json result = study_statistics(study, read_answers(study, files), given->bootstrap);
      give(program, result, {"choices", "ratings"}, study_tables(result));
      return result;
    };
  });
}

void add_calibration(CLI::App& evaluate, Program& program) {
  CLI::App* sub =
      evaluate.add_subcommand("calibration", "Coverage of stated uncertainties, and the factor that corrects it");
  struct Given {
    std::string table;
    CalibrationOptions options;
  };
  auto given = std::make_shared<Given>();
  sub->add_option("TABLE", given->table, "CSV: estimate, truth, sigma or low and high; quantity")->required();
  sub->add_option("--band", given->options.band,
                  fmt::format("Probability that low and high were stated for [{}]", kUsualBand))
      ->check(CLI::Range(0.01, 0.999))
      ->option_text("X");
  add_out(*sub, program, kTables);
  add_common(*sub, program);
  sub->callback([given, &program] {
    program.action = [given, &program](Context& context) {
      given->options.seed = context.seed;
      json result = evaluate_calibration(given->table, given->options);
      give(program, result, {"levels"}, calibration_tables(result));
      return result;
    };
  });
}

void add_self_test(CLI::App& evaluate, Program& program) {
  CLI::App* sub = evaluate.add_subcommand("self-test", "Every metric on small inputs with known answers");
  add_out(*sub, program, kTables);
  add_common(*sub, program);
  sub->callback([&program] {
    program.action = [&program](Context&) {
      json result = self_test();
      give(program, result, {"checks"}, self_test_tables(result));
      if (result["failed"] > 0) {
        if (program.json) std::printf("%s\n", result.dump(2).c_str());
        throw Error(Failure::kInput, "evaluate", "self-test", result["failed"].dump() + " checks failed",
                    "this build must not be trusted");
      }
      return result;
    };
  });
}

}  // namespace

void add_evaluate_tables(CLI::App& evaluate, Program& program) {
  add_compare(evaluate, program);
  add_study(evaluate, program);
  add_calibration(evaluate, program);
  add_self_test(evaluate, program);
}

}  // namespace pliant
