#include "fitting/observe/guidance.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "fitting/observe/child_process.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/json_file.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {

constexpr double kEndLimit = 5;  // s for the program to end by itself

struct Guidance::State {
  GuidanceOptions options;
  fs::path folder;
  ChildProcess process;
  std::string name;
  int step = 0;

  State(const GuidanceOptions& options, const fs::path& folder)
      : options(options),
        folder(folder),
        process({options.command, fs::absolute(folder).string(), folder / "log.txt", true, options.interrupted}),
        step(options.first_step) {}

  Error complaint(const std::string& problem, const std::string& remedy) const {
    return input_error(options.command, "", problem + process.last_words(), remedy);
  }

  /// The next line of JSON within the limit.
  json answer(double limit, const std::string& to) {
    std::string line;
    const auto start = std::chrono::steady_clock::now();
    while (true) {
      const double spent = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      switch (process.read_line(line, limit - spent)) {
        case ChildProcess::Read::kTooLate:
          process.kill();
          throw complaint(fmt::format("gave no answer to {} within {:.4g} s", to, limit),
                          "allow it more time, or render fewer or smaller frames");
        case ChildProcess::Read::kEnd: {
          const std::optional<int> code = process.wait(kEndLimit);
          throw complaint(
              fmt::format("ended before it answered {}{}", to, code ? fmt::format(", with exit code {}", *code) : ""),
              "see " + (folder / "log.txt").string());
        }
        case ChildProcess::Read::kLine:
          break;
      }
      if (!line.empty() && line[0] == '{') break;
    }
    json value = parse_json(line, options.command, "its answer to " + to);
    if (value.contains("error"))
      throw complaint(
          fmt::format("could not do {}: {}", to,
                      value["error"].is_string() ? value["error"].get<std::string>() : value["error"].dump()),
          "");
    return value;
  }
};

Guidance::Guidance(const GuidanceOptions& options, const fs::path& folder) {
  fs::create_directories(folder);
  state_ = std::make_unique<State>(options, folder);
  const json ready = state_->answer(options.start_limit, "its start");
  if (!ready.contains("ready") || ready["ready"] != 1)
    throw state_->complaint("sent " + ready.dump() + " at its start",
                            "its first line must be {\"ready\": 1, \"name\": \"...\"}");
  state_->name =
      ready.contains("name") && ready["name"].is_string() ? ready["name"].get<std::string>() : options.command;
}

Guidance::~Guidance() {
  try {
    state_->options.interrupted = nullptr;
    state_->process.write_line("{\"quit\": 1}", kEndLimit);
    state_->process.close_input();
    state_->process.wait(kEndLimit);
  } catch (const std::exception&) {
    // It is killed with the process object.
  }
}

const std::string& Guidance::name() const { return state_->name; }

int Guidance::next_step() { return state_->step++; }

GuidanceResult Guidance::evaluate(std::span<const ImageF> frames, double fps, int step) {
  State& s = *state_;
  CHECK(!frames.empty());
  const int width = frames[0].width, height = frames[0].height;
  const fs::path gradient_file = s.folder / "gradient.f32";
  fs::remove(gradient_file);
  {
    std::ofstream out(s.folder / "frames.f32", std::ios::binary);
    for (const ImageF& frame : frames) {
      CHECK(frame.width == width && frame.height == height && frame.channels == 3);
      out.write(reinterpret_cast<const char*>(frame.data.data()),
                static_cast<std::streamsize>(frame.data.size() * sizeof(float)));
    }
    if (!out.flush())
      throw input_error((s.folder / "frames.f32").string(), "", "cannot be written", "free some space on the disk");
  }
  const std::string what = fmt::format("step {}", step);
  const json request = {{"step", step},
                        {"frames", "frames.f32"},
                        {"gradient", "gradient.f32"},
                        {"shape", {frames.size(), height, width, 3}},
                        {"fps", fps}};
  if (!s.process.write_line(request.dump(), s.options.step_limit)) {
    const std::optional<int> code = s.process.wait(kEndLimit);
    throw s.complaint(
        fmt::format("does not accept {}{}", what, code ? fmt::format(": it ended with exit code {}", *code) : ""),
        "see " + (s.folder / "log.txt").string());
  }
  const json answer = s.answer(s.options.step_limit, what);
  const auto is_number = [&](const char* key) { return answer.contains(key) && answer[key].is_number(); };
  if (!is_number("step") || answer["step"].get<double>() != step || !is_number("loss") ||
      !std::isfinite(answer["loss"].get<double>()))
    throw s.complaint("answered " + answer.dump() + " to " + what,
                      fmt::format("it must answer {{\"step\": {}, \"loss\": NUMBER}}", step));

  GuidanceResult result;
  result.loss = answer["loss"].get<double>();
  const size_t bytes = frames.size() * frames[0].data.size() * sizeof(float);
  std::error_code missing;
  const auto written = fs::file_size(gradient_file, missing);
  if (missing || written != bytes)
    throw s.complaint(fmt::format("left {} in gradient.f32 at {}, {} bytes are expected",
                                  missing ? "nothing" : fmt::format("{} bytes", written), what, bytes),
                      "it must write as many 32-bit floats as frames.f32 has");
  std::ifstream in(gradient_file, std::ios::binary);
  for (size_t t = 0; t < frames.size(); ++t) {
    ImageF gradient(width, height, 3);
    in.read(reinterpret_cast<char*>(gradient.data.data()),
            static_cast<std::streamsize>(gradient.data.size() * sizeof(float)));
    for (size_t i = 0; i < gradient.data.size(); ++i)
      if (!std::isfinite(gradient.data[i]))
        throw s.complaint(fmt::format("wrote a derivative that is not finite at {}: frame {}, float {}", what, t, i),
                          "lower its guidance weight, or compute in higher precision");
    result.gradient.push_back(std::move(gradient));
  }
  if (!in) throw input_error(gradient_file.string(), "", "cannot be read", "check the disk");
  return result;
}

}  // namespace pliant
