#include "app/commands/program.h"

#include <omp.h>
#include <signal.h>

#include <algorithm>
#include <charconv>
#include <csignal>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>

#include "app/commands/command.h"
#include "app/commands/option_parser.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

volatile std::sig_atomic_t interrupt_requested = 0;

/// The first signal asks the running stage to stop at its next safe point, the second one ends the program.  A terminal
/// that is closed sends SIGHUP more than once.
void request_interrupt(int signal) {
  if (interrupt_requested && signal != SIGHUP) std::_Exit(128 + signal);
  interrupt_requested = 1;
}

/// The command that the arguments choose.
const CLI::App& chosen_command(const CLI::App& app, const std::vector<std::string>& arguments) {
  const CLI::App* command = &app;
  for (size_t i = 0; i < arguments.size(); ++i) {
    if (arguments[i].starts_with("-")) {
      const CLI::Option* option = command->get_option_no_throw(arguments[i]);
      if (option && option->get_items_expected_max() > 0) ++i;  // its value
      continue;
    }
    const auto named = [&](const CLI::App* sub) { return sub->check_name(arguments[i]); };
    if (const auto found = command->get_subcommands(named); !found.empty()) command = found.front();
  }
  return *command;
}

/// Whether the arguments hold an option, by any of its names.
bool is_given(const CLI::Option& option, const std::vector<std::string>& arguments) {
  return std::any_of(arguments.begin(), arguments.end(), [&](const std::string& argument) {
    return option.check_name(argument.substr(0, argument.find('=')));
  });
}

bool is_number_list(const nlohmann::json& value) {
  return value.is_array() && !value.empty() &&
         std::all_of(value.begin(), value.end(), [](const nlohmann::json& item) { return item.is_number(); });
}

/// A JSON value as it is typed behind an option: a list of numbers with commas.
std::string word_of(const nlohmann::json& value) {
  if (value.is_string()) return value.get<std::string>();
  if (!is_number_list(value)) return value.dump();
  std::string word;
  for (const nlohmann::json& number : value) word += (word.empty() ? "" : ",") + number.dump();
  return word;
}

/// Turns the JSON object of --config FILE into options behind the user's own; those that the user gives are left out.
std::vector<std::string> expand_config(const CLI::App& app, int argc, const char* const* argv) {
  std::vector<std::string> arguments(argv + 1, argv + argc);
  for (size_t i = 0; i < arguments.size(); ++i) {
    std::string file;
    if (arguments[i].rfind("--config=", 0) == 0)
      file = arguments[i].substr(9);
    else if (arguments[i] == "--config" && i + 1 < arguments.size())
      file = arguments[i + 1];
    if (file.empty()) continue;
    const nlohmann::json config = nlohmann::json::parse(read_text(file), nullptr, false);
    if (!config.is_object())
      throw usage_error(file, "", "is not a JSON object", "write {\"young\": 20000, \"duration\": 4}");
    arguments.erase(arguments.begin() + i, arguments.begin() + i + (arguments[i] == "--config" ? 2 : 1));
    const CLI::App& command = chosen_command(app, arguments);
    std::vector<std::string> options;
    for (const auto& [key, value] : config.items()) {
      const std::string flag = "--" + key;
      const CLI::Option* option = command.get_option_no_throw(flag);
      if (option && is_given(*option, arguments)) continue;
      const bool repeated = option && option->get_multi_option_policy() == CLI::MultiOptionPolicy::TakeAll;
      const bool several = value.is_array() && (repeated || !is_number_list(value));
      const nlohmann::json list = several ? value : nlohmann::json::array({value});
      for (const nlohmann::json& item : list) {
        const bool is_flag = option && option->get_items_expected_max() == 0;
        if (is_flag && item == false) continue;
        // Without a value, an option would take the next one for it.
        if (option && (item.is_null() || (!is_flag && item.is_boolean())))
          throw usage_error(file, flag, "is " + item.dump(), is_flag ? "give true or false" : "give a value");
        options.push_back(flag);  // which is refused where there is no such option
        if (!item.is_boolean()) options.push_back(word_of(item));
      }
    }
    arguments.insert(arguments.end(), options.begin(), options.end());
    if (std::any_of(arguments.begin(), arguments.end(),
                    [](const std::string& word) { return word == "--config" || word.rfind("--config=", 0) == 0; }))
      throw usage_error("--config", file, "is not the only one", "put all options into one file");
    break;
  }
  return arguments;
}

/// CLI11's message about a word that is no command where one has to be, with the nearest command; about an unknown
/// option, with what took its place or the nearest known one.
std::string with_nearest_name(const CLI::App& app, const Program& program, const std::string& message) {
  const CLI::App* command = &app;
  while (!command->get_subcommands().empty()) command = command->get_subcommands().front();
  if (command->get_require_subcommand_min() > 0) {
    const std::vector<std::string> words = command->remaining();
    const auto word = std::find_if(words.begin(), words.end(), [](const auto& text) { return !text.starts_with("-"); });
    if (word == words.end()) return message;
    std::vector<std::string> names;
    for (const CLI::App* sub : command->get_subcommands([](const CLI::App*) { return true; }))
      names.push_back(sub->get_name());
    return "'" + *word + "' is not a command" + (command == &app ? "" : " of " + command->get_name()) +
           "; did you mean '" + nearest_name(*word, names) + "'?";
  }
  const size_t at = message.rfind("--");
  if (message.find("not expected") == std::string::npos || at == std::string::npos) return message;
  const std::string given = message.substr(at, message.find_first_of(" =", at) - at);
  if (const auto renamed = program.renamed.find(command->get_name()); renamed != program.renamed.end())
    if (const auto now = renamed->second.find(given); now != renamed->second.end())
      return given + " is now " + now->second;
  std::vector<std::string> known;
  for (const CLI::Option* option : command->get_options())
    for (const std::string& name : option->get_lnames()) known.push_back("--" + name);
  return message + "; did you mean " + nearest_name(given, known) + "?";
}

/// Says what is wrong with a seed; empty where it is one.
std::string not_a_seed(const std::string& text) {
  uint64_t seed = 0;
  const char* end = text.data() + text.size();
  const auto [stop, failed] = std::from_chars(text.data(), end, seed);
  return failed == std::errc() && stop == end ? "" : "'" + text + "' is not a whole number from 0 to 2^64 - 1";
}

}  // namespace

void add_common(CLI::App& command, Program& program) {
  command.add_option("--seed", program.seed, "Random seed [1]")->option_text("N")->check(not_a_seed);
  command.add_option("--threads", program.threads, "Threads to use; 0 = all cores")
      ->option_text("N")
      ->check(CLI::NonNegativeNumber);
  command.add_flag("--quiet", program.quiet, "Print only warnings and errors");
  command.add_flag("--json", program.json, "Print the result as JSON on standard output");
  command.add_option("--config", "JSON object with option names and values; the command line wins")
      ->option_text("FILE");
}

CLI::Option* add_out(CLI::App& command, Program& program, const std::string& what) {
  return command.add_option("--out", program.out, what)->option_text("DIR");
}

CLI::Option* repeatable(CLI::Option* option) {
  return option->expected(1)->allow_extra_args(false)->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

void add_overwrite(CLI::App& command, Program& program, const std::string& what) {
  command.add_flag("--overwrite", program.overwrite, what);
}

void add_commands(CLI::App& app, Program& program) {
  app.description("Gaussian splats in, an object you can grab out.");
  app.name("pliant");
  app.set_version_flag("--version", PLIANT_VERSION);
  app.formatter(std::make_shared<HelpFormatter>(program.help_all));
  app.require_subcommand(1);
  for (auto* add :
       {add_run, add_demo, add_info, add_convert, add_reconstruct, add_segment, add_extract, add_repair, add_seed,
        add_predict, add_train_predictor, add_fit, add_simulate, add_render, add_export, add_view, add_evaluate})
    add(app, program);
}

int run_program(int argc, const char* const* argv) {
  CLI::App app;
  Program program;
  std::vector<const char*> words(argv, argv + argc);
  for (const char*& word : words) {
    if (std::string(word) != "--help-all") continue;
    program.help_all = true;
    word = "--help";
  }
  for (int i = 0; i < argc; ++i) program.command_line += (i ? " " : "") + quoted_word(argv[i]);
  add_commands(app, program);
  try {
    if (argc < 2) {
      std::fprintf(stderr, "%s", app.help().c_str());
      return static_cast<int>(Failure::kUsage);
    }
    std::vector<std::string> arguments = expand_config(app, argc, words.data());
    std::reverse(arguments.begin(), arguments.end());
    app.parse(arguments);

    interrupt_requested = 0;
    struct sigaction action = {};
    action.sa_handler = request_interrupt;
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
    struct sigaction hangup = {};
    sigaction(SIGHUP, nullptr, &hangup);
    if (hangup.sa_handler != SIG_IGN) sigaction(SIGHUP, &action, nullptr);  // as nohup has it
    if (program.threads > 0) omp_set_num_threads(program.threads);
    cv::setNumThreads(omp_get_max_threads());
    cv::setRNGSeed(static_cast<int>(program.seed));

    Progress progress(program.quiet);
    Context context{progress, [] { return interrupt_requested != 0; }, program.seed, omp_get_max_threads(),
                    program.overwrite};
    const nlohmann::json result = program.action(context);
    if (program.json) std::printf("%s\n", result.dump(2).c_str());
    if (interrupt_requested == 0 || program.ends_when_interrupted) return 0;
    std::fprintf(stderr, "pliant: interrupted, after all was done\n");
    return static_cast<int>(Failure::kInterrupted);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);
    std::fprintf(stderr, "pliant: %s\nRun with --help for the options.\n",
                 with_nearest_name(app, program, error.what()).c_str());
    return static_cast<int>(Failure::kUsage);
  } catch (const Error& error) {
    std::fprintf(stderr, "pliant: %s\n", error.what());
    return static_cast<int>(error.failure);
  } catch (const std::bad_alloc&) {
    std::fprintf(stderr, "pliant: out of memory\n");
    return 1;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "pliant: %s\n", error.what());
    return 1;
  }
}

}  // namespace pliant
