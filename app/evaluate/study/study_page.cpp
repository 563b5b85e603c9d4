#include "app/evaluate/study/study_page.h"

#include <nlohmann/json.hpp>

#include "app/evaluate/study/study_assets.h"
#include "app/report/html.h"
#include "gaussians/io/files/base64.h"
#include "gaussians/io/files/files.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace pliant {
namespace {

/// Source expression of Content Security Policy Level 3 for a script or style of this text.
std::string hash_source(const std::string& text) {
  const std::string hex = sha256_of_text(text);
  std::string bytes;
  for (size_t i = 0; i < hex.size(); i += 2) bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  return "'sha256-" + base64(bytes) + "'";
}

/// Clips as data URLs, each file once.
class Clips {
 public:
  size_t add(const fs::path& file) {
    const auto [found, is_new] = number_.emplace(file, urls_.size());
    if (is_new)
      urls_.push_back("data:video/" + file.extension().string().substr(1) + ";base64," + base64(read_text(file)));
    return found->second;
  }
  json urls() const { return urls_; }

 private:
  std::map<fs::path, size_t> number_;
  json urls_ = json::array();
};

}  // namespace

std::string study_page(const StudyList& study) {
  Clips clips;
  json data = {{"id", study.id},
               {"title", study.title},
               {"introduction", study.introduction},
               {"seed", study.seed},
               {"pairs", json::array()},
               {"singles", json::array()},
               {"questions", json::array()},
               {"ratings", json::array()}};
  for (const StudyQuestion& q : study.questions) data["questions"].push_back({{"name", q.name}, {"text", q.text}});
  for (const StudyRating& r : study.ratings)
    data["ratings"].push_back({{"name", r.name},
                               {"text", r.text},
                               {"lowest", r.lowest},
                               {"highest", r.highest},
                               {"lowest_means", r.lowest_means},
                               {"highest_means", r.highest_means}});
  for (const StudyScene& scene : study.scenes)
    for (const auto& [method, clip] : scene.clips) {
      if (!study.ratings.empty())
        data["singles"].push_back({{"scene", scene.name}, {"method", method}, {"clip", clips.add(clip)}});
      if (method == study.ours || study.questions.empty()) continue;
      json pair = {{"scene", scene.name},
                   {"methods", {study.ours, method}},
                   {"first", clips.add(scene.clips.at(study.ours))},
                   {"second", clips.add(clip)}};
      if (scene.reference) pair["reference"] = clips.add(*scene.reference);
      data["pairs"].push_back(std::move(pair));
    }
  if (!study.questions.empty())
    for (size_t i = 0; i < study.checks.size(); ++i)
      data["pairs"].push_back({{"check", true},
                               {"scene", "check " + std::to_string(i + 1)},
                               {"methods", {"good", "broken"}},
                               {"first", clips.add(study.checks[i].good)},
                               {"second", clips.add(study.checks[i].broken)}});
  data["clips"] = clips.urls();

  const std::string style(study_style()), script = in_script(std::string(study_script()));
  std::string page(study_template());
  fill_mark(page, "<!--POLICY-->",
            "default-src 'none'; script-src " + hash_source(script) + "; style-src " + hash_source(style) +
                "; media-src data:; base-uri 'none'; form-action 'none'");
  fill_mark(page, "/*STYLE*/", style);
  fill_mark(page, "/*SCRIPT*/", script);
  fill_mark(page, "<!--STUDY-->", json_in_script(data));
  fill_mark(page, "<!--TITLE-->", html_escaped(study.title));
  return page;
}

}  // namespace pliant
