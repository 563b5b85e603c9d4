#include <fmt/format.h>

#include "app/pipeline/stages.h"
#include "gaussians/io/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string base64(const std::string& bytes) {
  static const char kAlphabet[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string out;
  out.reserve((bytes.size() + 2) / 3 * 4);
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0);
    for (int k = 0; k < 4; ++k)
      out += i + k > bytes.size() ? '=' : kAlphabet[group >> (18 - 6 * k) & 63];
  }
  return out;
}

std::string escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '<') out += "&lt;";
    else if (c == '>') out += "&gt;";
    else if (c == '&') out += "&amp;";
    else if (c == '"') out += "&quot;";
    else out += c;
  }
  return out;
}

std::string picture(const RunDirectory& run, const std::string& file, const std::string& caption) {
  if (!fs::exists(run / file)) return "";
  return fmt::format("<figure><img src=\"data:image/png;base64,{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n",
                     base64(read_text(run / file)), escaped(caption), escaped(caption));
}

std::string video(const RunDirectory& run, const std::string& file, const std::string& caption) {
  if (!fs::exists(run / file)) return "";
  return fmt::format("<figure><video src=\"data:video/mp4;base64,{}\" controls loop muted autoplay playsinline></video>"
                     "<figcaption>{}</figcaption></figure>\n",
                     base64(read_text(run / file)), escaped(caption));
}

std::string times_table(const json& stages) {
  std::string rows;
  double total = 0;
  for (const char* name : {"segment", "extract", "repair", "seed", "simulate", "render"}) {
    if (!stages.contains(name)) continue;
    const double seconds = stages[name]["wall_s"];
    total += seconds;
    rows += fmt::format("<tr><td>{}</td><td>{:.1f}</td><td>{:.0f}</td><td><code>{}</code></td></tr>\n", name, seconds,
                        stages[name]["peak_memory_mb"].get<double>(), escaped(stages[name]["options"].dump()));
  }
  return fmt::format("<table><tr><th>stage</th><th>seconds</th><th>peak memory [MB]</th><th>options</th></tr>\n{}"
                     "<tr><td>all</td><td>{:.1f}</td><td></td><td></td></tr></table>\n",
                     rows, total);
}

std::string rules_table(const json& extract) {
  if (!extract.contains("rules")) return "";
  std::string rows;
  for (const auto& [name, rule] : extract["rules"].items())
    rows += fmt::format("<tr><td>{}</td><td>{}</td><td>{}</td><td>{:.3f} %</td></tr>\n", escaped(name), rule.value("moved", 0), rule["gaussians"].get<size_t>(),
                        100 * rule["opacity_share"].get<double>());
  return "<table><tr><th>rule</th><th>Gaussians moved</th><th>not moved again by a later rule</th><th>share of the candidates' opacity</th></tr>\n" + rows + "</table>\n";
}

}  // namespace

void write_report(const RunDirectory& run, const Scene& scene, const std::string& command) {
  const json& stages = run.manifest()["stages"];
  const json& simulate = stages["simulate"]["summary"];
  const json& extract = stages["extract"]["summary"];
  std::string html = "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>Pliant report</title><style>"
                     "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222}"
                     "img,video{max-width:100%;border:1px solid #ccc}figure{margin:1rem 0}figcaption{color:#555}"
                     "table{border-collapse:collapse}td,th{border:1px solid #ccc;padding:.2rem .6rem;text-align:left;vertical-align:top}"
                     "code{font-size:.85em;word-break:break-all}</style></head><body>\n";
  html += fmt::format("<h1>{}</h1>\n", escaped(scene.source.filename().string()));
  html += fmt::format("<p>{} Gaussians, {} cameras{}; up is {}; one unit is {:g} m.</p>\n", scene.cloud.size(), scene.cameras.size(),
                      scene.cameras_are_orbit ? " of an orbit" : "", escaped(scene.up_source), scene.metres_per_unit);
  html += video(run, "clip.mp4", "The object under the interactions, fixed camera");
  html += video(run, "clip_orbit.mp4", "The same, from a moving camera");
  html += picture(run, "clip_frames.png", "Eight moments of the clip");
  html += fmt::format("<p>Object <b>{}</b>: {} Gaussians. Mass {:.4g} kg; tip moves {:.1f} % of the object's height and ends at {:.1f} %.</p>\n",
                      escaped(extract.value("name", "")), extract.value("object_gaussians", 0), simulate.value("mass_kg", 0.0),
                      100 * simulate["motion"].value("tip_peak", 0.0), 100 * simulate["motion"].value("tip_end", 0.0));
  html += "<h2>Objects</h2>\n" + picture(run, "objects.png", "Objects found, with id and name");
  for (const json& edit : run.note("edits")) html += "<p>By hand: " + escaped(edit.value("did", "")) + ".</p>\n";
  html += picture(run, "features.png", "Semantic attribute: its first three principal components as red, green and blue");
  html += "<h2>Extract</h2>\n" + picture(run, "extract.png", "The object, and what each rule took from it or gave to it") + rules_table(extract);
  html += "<h2>Repair</h2>\n" + picture(run, "repair.png", "Before, hole, after");
  html += "<h2>Times</h2>\n" + times_table(stages);
  html += "<h2>Interactions</h2>\n<pre>" + escaped(read_text(run / "interactions.json")) + "</pre>\n";
  html += fmt::format("<h2>Reproduce</h2>\n<pre>{}</pre>\n<p>Pliant {}, seed {}.</p>\n</body></html>\n", escaped(command),
                      PLIANT_VERSION, stages["simulate"]["options"]["seed"].dump());
  write_text(run / "report.html", html);
}

}  // namespace pliant
