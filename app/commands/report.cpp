#include "app/commands/report.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/fit/fit_report.h"
#include "app/report/html.h"
#include "app/run/attach_scene.h"
#include "gaussians/io/files/files.h"

namespace pliant {
using nlohmann::json;

namespace {

std::string times_table(const json& stages) {
  std::string rows;
  double total = 0;
  for (const char* name :
       {"label", "segment", "extract", "repair", "fill", "seed", "predict", "fit", "simulate", "render", "page"}) {
    if (!stages.contains(name)) continue;
    const double seconds = stages[name]["wall_s"];
    total += seconds;
    rows += fmt::format("<tr><td>{}</td><td>{:.1f}</td><td>{:.0f}</td><td><code>{}</code></td></tr>\n", name, seconds,
                        stages[name]["peak_memory_mb"].get<double>(), html_escaped(stages[name]["options"].dump()));
  }
  return fmt::format(
      "<table><tr><th>stage</th><th>seconds</th><th>peak memory [MB]</th><th>options</th></tr>\n{}"
      "<tr><td>total</td><td>{:.1f}</td><td></td><td></td></tr></table>\n",
      rows, total);
}

std::string rules_table(const json& extract) {
  if (!extract.contains("rules")) return "";
  std::string rows;
  for (const auto& [name, rule] : extract["rules"].items())
    rows +=
        fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.3f} %</td></tr>\n", html_escaped(name),
                    rule.value("moved", 0), rule["gaussians"].get<size_t>(), 100 * rule["opacity_share"].get<double>());
  return "<table><tr><th>rule</th><th>Gaussians moved</th><th>not moved again by a later rule</th><th>share of the "
         "candidates' opacity</th></tr>\n" +
         rows + "</table>\n";
}

/// Empty where there is no band: a frequency of 0 is that of a thing that counts as rigid.
std::string band_text(const json& band) {
  if (!band.is_object() || band["high"] == 0) return "";
  return fmt::format("{:.3g} to {:.3g}", band["low"].get<double>(), band["high"].get<double>());
}

/// Whether the prediction was told this property.
bool was_given(const json& prediction, const char* key) {
  const json given = prediction.value("given", json::array());
  return std::find(given.begin(), given.end(), key) != given.end();
}

/// Whether what was simulated has this property by the prediction; a record that says nothing of it counts as that.
bool is_predicted(const RunDirectory& run, const json& stages, const std::string& key) {
  const json &simulate = stages["simulate"], &predict = stages["predict"];
  if (simulate["found"].contains("predicted")) return true;
  const bool fitted = simulate["found"].value("fitted", false) && stages.contains("fit");
  if (fitted && key == "young") return false;  // it was found
  const json& record = fitted ? stages["fit"] : simulate;
  if (const char* role = fitted ? "initial_material" : "material"; record["inputs"].contains(role)) {
    const std::filesystem::path file = run / predict["outputs"][0].get<std::string>();
    return std::filesystem::exists(file) && record["inputs"][role] == hash_of_input(file);
  }
  const json material = record["found"].value("material", json::object());
  return !material.contains(key) || material[key] == predict["summary"][key];
}

/// What nobody said and was assumed, with where it comes from; empty where all was given.
std::string assumptions(const RunDirectory& run, const Scene& scene, const json& stages) {
  std::string rows;
  const auto add = [&](const char* what, const std::string& value, const std::string& band, const std::string& source) {
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>\n", what, html_escaped(value), band,
                        html_escaped(source));
  };
  const json& extract = stages["extract"]["summary"];
  if (extract.contains("chosen")) add("object", extract["name"], "", extract["chosen"]);
  if (!scene.settings.up && !run.scene().contains("up"))
    add("up", fmt::format("{:.3f}, {:.3f}, {:.3f}", scene.up.x(), scene.up.y(), scene.up.z()), "", scene.up_source);
  if (assumed_height(run))
    add("height [m]", fmt::format("{:g}", scene.object_height), "", "typical height for the label");
  else if (scene.object_height == 0 && !scene.settings.metres_per_unit && !run.scene().contains("metres_per_unit"))
    add("length of a unit [m]", "1", "", "unknown");
  if (stages.contains("predict")) {
    const json& p = stages["predict"]["summary"];
    std::string source = fmt::format("{}: {}", p["understood"].get<std::string>(), p["source"].get<std::string>());
    const auto add_predicted = [&](const char* key, const char* what, int digits) {
      if (was_given(p, key) || !is_predicted(run, stages, key)) return;
      add(what, fmt::format("{:.{}g}", p[key].get<double>(), digits), band_text(p[std::string(key) + "_band"]), source);
      source = "the same";
    };
    add_predicted("young", "mean of Young's modulus E [Pa]", 3);
    add_predicted("poisson", "Poisson's ratio", 3);
    add_predicted("density", "density [kg/m^3]", 4);
    if (is_predicted(run, stages, "young") && p["frequency_hz"].is_number())
      add("sway frequency [Hz]", fmt::format("{:.2g}", p["frequency_hz"].get<double>()), band_text(p["frequency_band"]),
          source);
  }
  if (rows.empty()) return "";
  return "<h2>Assumed</h2>\n<table><tr><th>what</th><th>value</th><th>band</th><th>source</th></tr>\n" + rows +
         "</table>\n";
}

/// E on the object, and how well it is known where it was predicted.
std::string material_section(const RunDirectory& run, const json& stages) {
  std::string html = html_picture(run, "stiffness.png", "Young's modulus E on the object");
  if (html.empty()) return "";
  if (stages["simulate"]["found"].contains("predicted")) {
    const json& p = stages["predict"]["summary"];
    html += was_given(p, "young") ? fmt::format("<p>Mean as given: {:.3g} Pa; its distribution is predicted.</p>\n",
                                                p["young"].get<double>())
                                  : fmt::format("<p>Predicted mean: {:.3g} Pa; band {} Pa.</p>\n",
                                                p["young"].get<double>(), band_text(p["young_band"]));
  }
  return "<h2>Material</h2>\n" + html;
}

}  // namespace

void write_report(const RunDirectory& run, const Scene& scene, const std::string& command) {
  const json& stages = run.manifest()["stages"];
  const json& simulate = stages["simulate"]["summary"];
  const json& extract = stages["extract"]["summary"];
  std::string html = html_begin("Pliant report");
  html += fmt::format("<h1>{}</h1>\n", html_escaped(scene.source.filename().string()));
  html += fmt::format("<p>{} Gaussians, {} cameras{}; up is {}; one unit is {:g} m.</p>\n", scene.cloud.size(),
                      scene.cameras.size(), scene.cameras_are_orbit ? " of an orbit" : "",
                      html_escaped(scene.up_source), scene.metres_per_unit);
  html += html_video(run, "clip.mp4", "The object under the interactions, fixed camera");
  html += html_video(run, "clip_orbit.mp4", "The same, from a moving camera");
  if (run.has("page"))
    html +=
        "<p><a href=\"clip.html\">The page in which the object can be grabbed</a>; it opens in any browser, without a "
        "network.</p>\n";
  html += html_picture(run, "clip_frames.png", "Eight moments of the clip");
  html += fmt::format(
      "<p>Object <b>{}</b>: {} Gaussians. Mass {:.4g} kg; tip moves {:.1f} % of the object's height and ends at {:.1f} "
      "%.</p>\n",
      html_escaped(extract.value("name", "")), extract.value("object_gaussians", 0), simulate.value("mass_kg", 0.0),
      100 * simulate["motion"].value("tip_peak", 0.0), 100 * simulate["motion"].value("tip_end", 0.0));
  html += assumptions(run, scene, stages);
  html += "<h2>Objects</h2>\n" + html_picture(run, "objects.png", "Objects found, with id and name");
  for (const json& edit : run.note("edits"))
    html += "<p>Manual edit: " + html_escaped(edit.value("did", "")) + ".</p>\n";
  html += html_picture(run, "features.png",
                       "Semantic attribute: its first three principal components as red, green and blue");
  html += "<h2>Extract</h2>\n" +
          html_picture(run, "extract.png", "The object, and the Gaussians that each rule removed or added") +
          rules_table(extract);
  html += "<h2>Repair</h2>\n" + html_picture(run, "repair.png", "Before, hole, after");
  html += "<h2>Body</h2>\n" + html_picture(run, "pieces.png", "Connected pieces of the simulated body");
  html += material_section(run, stages);
  if (stages["simulate"]["found"].value("fitted", false)) html += "<h2>Fit</h2>\n" + fit_section(run);
  html += "<h2>Times</h2>\n" + times_table(stages);
  html += "<h2>Interactions</h2>\n<pre>" + html_escaped(read_text(run / "interactions.json")) + "</pre>\n";
  html += fmt::format("<h2>Reproduce</h2>\n<pre>{}</pre>\n<p>Pliant {}, seed {}.</p>\n</body></html>\n",
                      html_escaped(command), PLIANT_VERSION, stages["simulate"]["seed"].dump());
  write_text(run / "report.html", html);
}

}  // namespace pliant
