// The options of every stage are described in one table each; commands write them as the tables say.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "app/commands/stage_options.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/files.h"
#include "gaussians/io/files/json_file.h"
#include "gaussians/io/splats/ply.h"
#include "tests/app/beam_scene.h"
#include "tests/app/commands/all_tables.h"
#include "tests/app/run_pliant.h"
#include "tests/temporary_folder.h"

namespace pliant {
namespace {

/// What a command prints on standard output and on standard error, and its exit code.
struct Printed {
  std::string out, error;
  int code = 0;
};
Printed print(std::vector<std::string> arguments) {
  Printed printed;
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  printed.code = run_pliant(std::move(arguments));
  printed.out = testing::internal::GetCapturedStdout();
  printed.error = testing::internal::GetCapturedStderr();
  return printed;
}

}  // namespace

TEST(Options, EachIsDescribedOnceInOneSentence) {
  size_t count = 0;
  for (const OptionTable& table : all_tables()) {
    std::set<std::string> names;
    for (const Option& option : table.options) {
      ++count;
      const std::string where = table.stage + "." + option.name;
      EXPECT_TRUE(names.insert(option.name).second) << where << " stands twice in its table";
      EXPECT_NE(option.formerly, option.name) << where;
      EXPECT_GT(option.help.size(), 8u) << where;
      EXPECT_LE(option.help.size(), 130u) << where;
      EXPECT_NE(option.help.back(), '.') << where;
      EXPECT_EQ(option.off, option.name.starts_with("no-")) << where;
      EXPECT_TRUE(!option.off || std::holds_alternative<bool*>(option.field)) << where;
    }
  }
  EXPECT_GT(count, 120u);
}

// The default of a field is a value that its option takes.
TEST(Options, DefaultsLieInTheirRanges) {
  for (const OptionTable& table : all_tables())
    for (const Option& option : table.options) {
      const std::string where = table.stage + "." + option.name, text = field_text(option.field);
      if (std::holds_alternative<int*>(option.field) || std::holds_alternative<double*>(option.field)) {
        const double value = std::stod(text);
        EXPECT_TRUE(value >= option.low && value <= option.high && (!option.positive || value > 0)) << where;
      }
      if (std::holds_alternative<std::string*>(option.field) && !option.choices.empty() && !text.empty()) {
        EXPECT_TRUE(std::set<std::string>(option.choices.begin(), option.choices.end()).count(text)) << where;
      }
    }
}

TEST(Options, AreTakenFromARecordAsTheyWereRecorded) {
  for (const OptionTable& table : all_tables())
    for (const Option& option : table.options) {
      const nlohmann::json value = field_json(option.field);
      set_field(option.field, value);
      EXPECT_EQ(field_json(option.field), value) << table.stage + "." + option.name;
    }
  const auto expect_same = [](auto given) {
    StageKey before, after;
    record_options(options_of(given), before);
    decltype(given) taken;
    take_recorded(before.options, options_of(taken));
    record_options(options_of(taken), after);
    EXPECT_EQ(before.options, after.options);
  };
  PredictStage predict;
  predict.label = "potted palm";
  predict.softness = 0.3;
  predict.given.density = 700;
  expect_same(predict);
  PageStage page;
  page.html = false;
  page.size = 3'000'000;
  expect_same(page);
}

TEST(Options, OfAStageNeedNoPrefixInItsOwnCommandAndHaveOneInRun) {
  const Printed run = print({"run", "--help-all"});
  EXPECT_EQ(run.code, 0);
  for (const OptionTable& table : all_tables()) {
    const std::string command = table.stage == "page" ? "export" : table.stage, own = print({command, "--help"}).out;
    for (const Option& option : table.options) {
      if (option.name != "no-html") {
        EXPECT_NE(own.find("--" + option.name), std::string::npos) << command << " --" << option.name;
      }
      if (table.stage == "export") continue;  // not a part of `run`
      const bool shown = run.out.find("--" + table.stage + "." + option.name) != std::string::npos ||
                         run.out.find("  --" + option.name) != std::string::npos;
      const bool of_run = (table.stage == "simulate" && option.name == "no-fit") ||
                          (table.stage == "fit" && option.name == "solver") ||  // that of simulate
                          (table.stage == "seed" && option.name == "material") ||
                          (table.stage == "render" && option.name == "recorded");  // `run` records nothing
      EXPECT_TRUE(shown || of_run) << "run --" << table.stage << "." << option.name;
    }
  }
}

TEST(Options, HelpOfRunFitsOnOneScreen) {
  const Printed help = print({"run", "--help"});
  EXPECT_EQ(help.code, 0);
  EXPECT_LE(std::count(help.out.begin(), help.out.end(), '\n'), 45);
  size_t begin = 0;
  while (begin < help.out.size()) {
    const size_t end = help.out.find('\n', begin);
    EXPECT_LE(end - begin, 100u) << help.out.substr(begin, end - begin);
    begin = end + 1;
  }
}

TEST(Options, AnEarlierSpellingIsRefusedWithTheNewOne) {
  const auto refused = [](std::vector<std::string> arguments, const std::string& now) {
    const Printed printed = print(arguments);
    EXPECT_EQ(printed.code, 2) << now;
    EXPECT_NE(printed.error.find("is now " + now), std::string::npos) << printed.error;
  };
  refused({"seed", "dir", "--drivers", "pgas"}, "--sampling");
  refused({"simulate", "dir", "--push=0.1"}, "--auto-push");
  refused({"fit", "dir", "--until", "2"}, "--end");
  refused({"segment", "scene", "--segment-iterations", "5"}, "--iterations");
  refused({"run", "scene", "--fps", "12"}, "--simulate.fps");
  refused({"run", "scene", "--fit-until", "2"}, "--fit.end");
  refused({"run", "scene", "--until", "repair"}, "--fit.end, a time of the video; to stop after a stage");
  refused({"run", "scene", "--particles", "500"}, "--seed.particles");
  refused({"run", "scene", "--camera", "a"}, "--render.camera");
  refused({"run", "scene", "--no-orbit"}, "--render.no-orbit");
  refused({"run", "scene", "--hold-out-every", "4"}, "--reconstruct.hold-out-every");
  refused({"segment", "scene", "--max-gaussians", "1k"}, "--reconstruct.max-gaussians");
}

TEST(Options, AMisspeltCommandIsNamedWithTheNearestOne) {
  const auto said = [](std::vector<std::string> words) {
    const Printed printed = print(std::move(words));
    EXPECT_EQ(printed.code, 2);
    return printed.error.substr(0, printed.error.find('\n'));
  };
  EXPECT_EQ(said({"rum", "scene.ply", "--fps", "12"}), "pliant: 'rum' is not a command; did you mean 'run'?");
  EXPECT_EQ(said({"evaluate", "imges", "a", "b"}),
            "pliant: 'imges' is not a command of evaluate; did you mean 'images'?");
  EXPECT_EQ(said({"evaluate"}), "pliant: A subcommand is required");
}

TEST(Options, HelpShowsWhatStandsForEveryValue) {
  CLI::App app;
  Program program;
  add_commands(app, program);
  int count = 0;
  const std::function<void(const CLI::App&)> walk = [&](const CLI::App& command) {
    for (const CLI::App* sub : command.get_subcommands([](const CLI::App*) { return true; })) walk(*sub);
    for (const CLI::Option* option : command.get_options()) {
      if (option->get_lnames().empty() || option->get_items_expected_max() == 0) continue;
      ++count;
      EXPECT_NE(option->get_option_text(), "") << command.get_name() << " " << option->get_name();
    }
  };
  walk(app);
  EXPECT_GT(count, 200);
  const std::string edit = print({"segment", "edit", "--help"}).out;
  for (const char* option : {"--merge ID,ID,...", "--split ID", "--drop ID", "--name ID=NAME"})
    EXPECT_NE(edit.find(std::string("  ") + option + " "), std::string::npos) << edit;
}

TEST(Options, ARepeatedOneTakesOneWordAtATime) {
  CLI::App app;
  Program program;
  SegmentStage stage;
  std::string scene;
  app.add_option("SCENE", scene);
  add_options(app, program, options_of(stage));
  std::vector<std::string> words = {"--click", "a,1,2", "--click", "a,3,4", "scene.ply"};
  std::reverse(words.begin(), words.end());
  app.parse(words);
  EXPECT_EQ(scene, "scene.ply");
  EXPECT_EQ(stage.clicks, (std::vector<std::string>{"a,1,2", "a,3,4"}));
}

TEST(Options, ValuesOutsideOfTheirRangeAreUsageErrors) {
  CLI::App app;
  Program program;
  add_commands(app, program);
  for (const OptionTable& table : all_tables())
    for (const Option& option : table.options) {
      const bool number = std::holds_alternative<int*>(option.field) || std::holds_alternative<double*>(option.field) ||
                          std::holds_alternative<std::optional<int>*>(option.field) ||
                          std::holds_alternative<std::optional<double>*>(option.field);
      std::vector<std::string> bad;
      if (number) bad = {"many", "nan"};
      if (number && std::isfinite(option.low)) bad.push_back(std::to_string(static_cast<int>(option.low) - 1));
      if (!option.choices.empty()) bad = {"nothing"};
      if (option.exists) bad = {"no/such/file"};
      for (const std::string& value : bad) {
        const std::string name = "--" + table.stage + "." + option.name;
        const Printed printed = print({table.stage, "dir", name + "=" + value});
        EXPECT_EQ(printed.code, 2) << name << " " << value;
        EXPECT_NE(printed.error.find(option.name), std::string::npos) << printed.error;
      }
      // Where several stages meet, the whole name is said.
      for (const char* command : {"run", "segment"}) {
        const CLI::Option* added =
            app.get_subcommand(command)->get_option_no_throw("--" + table.stage + "." + option.name);
        if (!added || bad.empty()) continue;
        const std::string name = "--" + added->get_lnames().front();
        const Printed printed = print({command, "scene", name + "=" + bad.front()});
        EXPECT_EQ(printed.code, 2) << name;
        EXPECT_NE(printed.error.find(name + ": "), std::string::npos) << name << ": " << printed.error;
      }
    }
  const auto refused = [](const std::vector<std::string>& words, const std::string& option, const std::string& value) {
    const Printed printed = print(words);
    EXPECT_EQ(printed.code, 2) << value;
    EXPECT_NE(printed.error.find(option), std::string::npos) << printed.error;
    EXPECT_NE(printed.error.find("'" + value + "'"), std::string::npos) << printed.error;
  };
  for (const std::string value : {"-3", "1.5", "many", "18446744073709551616"})
    refused({"seed", "dir", "--seed=" + value}, "--seed", value);
  for (const std::string value : {"-1", "1.5", "3e9", "fine"})
    refused({"convert", "a.ply", "b.ply", "--level=" + value}, "--level", value);
}

TEST(Options, OverwriteIsOfCommandsThatHaveSomethingToReplaceAndSaysWhat) {
  for (const std::string command : {"run", "segment", "reconstruct", "fit", "demo", "convert", "export"})
    EXPECT_NE(print({command, "--help"}).out.find("--overwrite"), std::string::npos) << command;
  const Printed demo = print({"demo", "--help"});
  EXPECT_NE(demo.out.find("Replace a demo that was made with other options"), std::string::npos) << demo.out;
  for (const std::string command : {"extract", "repair", "seed", "predict", "simulate", "render", "view"}) {
    EXPECT_EQ(print({command, "--help"}).out.find("--overwrite"), std::string::npos) << command;
    EXPECT_EQ(print({command, "dir", "--overwrite"}).code, 2) << command;
  }
}

TEST(Options, HelpOfRenderNamesWhatItTakes) {
  const std::string help = print({"render", "--help"}).out;
  EXPECT_NE(help.find("or a run directory"), std::string::npos) << help;
  EXPECT_EQ(help.find("posed photos"), std::string::npos) << help;
}

// What an option of one kind makes useless is refused by its name, before anything is written.
TEST(Options, WhatWouldBeIgnoredIsRefused) {
  const TemporaryFolder folder;
  const std::string config = folder.file("config.json", "{}").string(), out = (folder / "out").string();
  const std::string run = (folder / "run").string(), scene = (folder / "scene.ply").string();
  std::filesystem::create_directories(run);
  write_text(folder / "run/run.json", R"({"scene": null, "stages": {}})");
  GaussianCloud cloud;
  cloud.resize(20);
  write_ply(scene, cloud);
  const auto refused = [](std::vector<std::string> arguments, const std::string& option) {
    const Printed printed = print(arguments);
    EXPECT_EQ(printed.code, 2) << option;
    EXPECT_NE(printed.error.find(option + ": does nothing"), std::string::npos) << option << ": " << printed.error;
  };
  for (const std::string option : {"--particles=500", "--pin-below=0.1", "--no-pin-contact"})
    refused({"seed", run, "--physgaussian", config, option}, option.substr(0, option.find('=')));
  for (const std::string option : {"--fps=12", "--duration=1", "--damping-time=1", "--auto-push=0.1", "--settle-time=1",
                                   "--no-gravity", "--no-floor", "--young=1e4", "--law=sand", "--friction-angle=30"})
    refused({"simulate", run, "--physgaussian", config, option}, option.substr(0, option.find('=')));
  refused({"simulate", run, "--physgaussian-bugs"}, "--physgaussian-bugs");
  refused({"simulate", run, "--interactions", config, "--auto-push=0.1"}, "--auto-push");
  refused({"segment", scene, "--out", out, "--box", "0,1,1,9,9", "--masks", run}, "--masks");
  refused({"segment", scene, "--out", out, "--sphere", "0,0,0,1", "--associate", "never"}, "--associate");
  refused({"segment", scene, "--out", out, "--auto", "--stroke-width", "3"}, "--stroke-width");
  for (const std::string option : {"--aabb=0,0,0,1,1,1", "--sphere=0,0,0,1"})
    refused({"segment", scene, "--out", out, "--click", "0,1,1", "--segmenter", config, option},
            option.substr(0, option.find('=')));
  refused({"view", "--out", out, "--choose"}, "--choose");
  refused({"segment", scene, "--out", out, "--joint", "--no-vote"}, "--no-vote");
  refused({"segment", scene, "--out", out, "--gaussian-grouping", run, "--iterations", "5"}, "--iterations");
  refused({"segment", scene, "--out", out, "--reconstruct.exposure"}, "--reconstruct.exposure");
  refused({"run", scene, "--out", out, "--time-limit", "5m"}, "--time-limit");
  refused({"run", scene, "--out", out, "--physgaussian", config, "--simulate.fps", "12"}, "--simulate.fps");
  for (const std::string option : {"--depth", "--antialiased", "--background=1,1,1", "--up=0,0,1"})
    refused({"render", run, option}, option.substr(0, option.find('=')));
  refused({"render", run, "--out", out}, "--out");
  for (const std::string option : {"--html-size=100", "--page.html-license=CC0"})
    refused({"run", scene, "--out", out, "--no-html", option}, option.substr(0, option.find('=')));
  refused({"run", scene, "--out", out, "--repair.trust-torchscript"}, "--repair.trust-torchscript");
  refused({"repair", run, "--trust-torchscript"}, "--trust-torchscript");
  EXPECT_EQ(print({"run", scene, "--out", out, "--repair.inpainter", folder / "absent.onnx"}).code, 2);
  EXPECT_NE(print({"run", scene, "--out", out, "--repair.inpainter", config}).code, 0) << "is no network";
  refused({"evaluate", "suite", "--out", out, "--threads", "2"}, "--threads");
  refused({"evaluate", "suite", "--out", out, "--seed", "2"}, "--seed");
  refused({"render", scene, "--out", out, "--no-orbit"}, "--no-orbit");
  refused({"render", scene, "--out", out, "--turntable"}, "--turntable");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST(ConfigFile, GivesWayToTheCommandLineByAnyNameOfAnOption) {
  const TemporaryFolder folder;
  GaussianCloud cloud;
  cloud.sh_degree = 2;
  cloud.resize(3);
  for (Vec4f& rotation : cloud.rotation) rotation = Vec4f(1, 0, 0, 0);
  write_ply(folder / "in.ply", cloud);
  const auto degree = [&](const std::string& key, std::vector<std::string> more) {
    const std::string config = folder.file("config.json", "{\"" + key + "\": 0}").string();
    more.insert(more.begin(), {"convert", (folder / "in.ply").string(), (folder / "out.ply").string(), "--overwrite",
                               "--config", config});
    EXPECT_EQ(print(more).code, 0) << key;
    return read_ply(folder / "out.ply").sh_degree;
  };
  for (const std::string key : {"sh-degree", "convert.sh-degree"}) {
    EXPECT_EQ(degree(key, {}), 0);
    for (const std::string name : {"--sh-degree", "--convert.sh-degree"}) {
      EXPECT_EQ(degree(key, {name, "1"}), 1) << key << " " << name;
      EXPECT_EQ(degree(key, {name + "=1"}), 1) << key << " " << name;
    }
  }
}

TEST(ConfigFile, WhatIsNoFlagIsNotTurnedOff) {
  const TemporaryFolder folder;
  const std::string absent = (folder / "absent").string();
  const auto refused = [&](std::vector<std::string> command, const std::string& key,
                           const std::string& values = "false") {
    const std::string config = folder.file("config.json", "{\"" + key + "\": " + values + "}").string();
    command.insert(command.end(), {"--config", config});
    const Printed printed = print(command);
    EXPECT_EQ(printed.code, 2) << command[0] << " " << key;
    EXPECT_NE(printed.error.find("--" + key), std::string::npos) << printed.error;
  };
  refused({"run", absent}, "no-such");
  refused({"run", absent}, "video");  // a file
  refused({"demo", "--out", absent}, "video");
  // Without a value it does not take the next option for one.
  refused({"run", absent}, "label", R"(true, "no-video": true)");
  for (const char* none : {"true", "null"}) refused({"run", absent}, "label", none);
  refused({"run", absent}, "quiet", "null");
  const std::string config = folder.file("config.json", R"({"quiet": false, "json": false})").string();
  EXPECT_EQ(print({"info", absent, "--config", config}).code, 1) << "flags are";
}

TEST(ConfigFile, AListOfNumbersIsOneValueAsInASceneFile) {
  const TemporaryFolder folder;
  fixture::make_beam_scene(folder / "beam");
  const std::string splats = (folder / "beam/splats.ply").string(), out = (folder / "out").string();
  const auto segment = [&](const std::string& config) {
    return print({"segment", splats, "--out", out, "--config", folder.file("config.json", config).string()});
  };
  EXPECT_EQ(segment(R"({"up": [1e-7, 0.1, 0.7], "aabb": [-0.1, -0.1, 0.9, 1, 0.3000000000000004, 1.3]})").code, 0);
  const nlohmann::json run = read_json(out + "/run.json"), up = run["scene"]["up"];
  const Eigen::Vector3d wanted = Eigen::Vector3d(1e-7, 0.1, 0.7).normalized();
  EXPECT_EQ(Eigen::Vector3d(up[0], up[1], up[2]), wanted);
  EXPECT_EQ(run["stages"]["segment"]["options"]["aabb"],
            nlohmann::json({-0.1, -0.1, 0.9, 1.0, 0.3000000000000004, 1.3}));
  const Printed short_list =
      print({"segment", splats, "--out", out, "--config", folder.file("config.json", R"({"up": [0, 1]})").string()});
  EXPECT_EQ(short_list.code, 2);
  EXPECT_NE(short_list.error.find("--up"), std::string::npos) << short_list.error;
  // An option that may be repeated takes each item by itself.
  const Printed repeated = segment(R"({"click": [1, 2]})");
  EXPECT_EQ(repeated.code, 2);
  EXPECT_EQ(repeated.error.find("1,2"), std::string::npos) << repeated.error;
}

TEST(ConfigFile, ASecondOneIsRefusedWhereverItIsNamed) {
  const TemporaryFolder folder;
  const std::string other = folder.file("other.json", R"({"quiet": true})").string(),
                    names = folder.file("names.json", R"({"config": "other.json"})").string();
  for (const std::vector<std::string>& more : {std::vector<std::string>{"--config", names},
                                               {"--config", other, "--config", other},
                                               {"--config", other, "--config=" + other}}) {
    std::vector<std::string> command = {"info", "absent"};
    command.insert(command.end(), more.begin(), more.end());
    const Printed printed = print(command);
    EXPECT_EQ(printed.code, 2);
    EXPECT_NE(printed.error.find("one file"), std::string::npos) << printed.error;
  }
}

TEST(OutFolder, IsNamedAfterALinkToSplatsAndNotAfterTheirFile) {
  const TemporaryFolder folder;
  folder.file("blobs/0123abcd", "");
  std::filesystem::create_symlink("blobs/0123abcd", folder / "flower.ply");
  std::filesystem::create_directory_symlink(folder / "blobs", folder / "link");
  EXPECT_EQ(default_out((folder / "flower.ply").string(), "run"), "flower_run");
  EXPECT_EQ(default_out((folder / "link").string(), "run"), "blobs_run");
}

// A reconstructed scene has a run.json, which is about its training.
TEST(ViewCommand, TakesAFolderWithASceneForTheSceneAndNotForARun) {
  const TemporaryFolder folder;
  const std::string scene = folder.file("scene/scene.json", R"({"splats": "absent.ply"})").parent_path();
  folder.file("scene/run.json", R"({"scene": null, "stages": {}})");
  const Printed printed = print({"view", scene, "--out", (folder / "out").string(), "--no-browser"});
  EXPECT_EQ(printed.code, 1);
  EXPECT_NE(printed.error.find("absent.ply"), std::string::npos) << printed.error;
}

TEST(SceneOptions, UpIsThreeNumbersOrAnAxis) {
  const auto up_of = [](const std::string& text) {
    SceneOptions options;
    options.up = text;
    return options.load_options().up;
  };
  EXPECT_FALSE(up_of(""));
  EXPECT_EQ(up_of("0,0,-2"), Eigen::Vector3d(0, 0, -1));
  EXPECT_EQ(up_of("-y"), Eigen::Vector3d(0, -1, 0));
  for (const char* wrong : {"up", "0,0", "0,0,0", "z,x,y", "-"})
    expect_error(Failure::kUsage, {"--up"}, [&] { up_of(wrong); });

  // Its dash does not make it an option.
  const TemporaryFolder folder;
  GaussianCloud cloud;
  cloud.resize(20);
  for (int i = 0; i < 20; ++i) cloud.position[i] = Vec3f(0.1f * i, 0, 0.1f * (i % 3));
  write_ply(folder / "scene.ply", cloud);
  const std::string scene = (folder / "scene.ply").string(), out = (folder / "out").string();
  const Printed printed = print({"segment", scene, "--out", out, "--sphere", "0,0,0,1", "--up", "-z"});
  EXPECT_NE(printed.error.find("up: given by the user"), std::string::npos) << printed.error;
}

}  // namespace pliant
