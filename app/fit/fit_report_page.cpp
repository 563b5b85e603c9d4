#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "app/fit/fit_report.h"
#include "app/report/html.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string numbers(const json& fit) {
  std::string rows;
  const auto row = [&](const char* key, const char* name, const char* format, double scale = 1) {
    if (fit.contains(key) && fit[key].is_number())
      rows += fmt::format("<tr><td>{}</td><td>{}</td></tr>\n", name,
                          fmt::format(fmt::runtime(format), scale * fit[key].get<double>()));
  };
  row("young_pa", "Young's modulus", "{:.4g} Pa");
  row("young_before_pa", "Young's modulus before the fit", "{:.4g} Pa");
  row("log10_sigma", "standard deviation of log10 E from noise alone", "{:.3f} decades");
  row("poisson", "Poisson's ratio", "{:.3f}");
  row("density_kg_m3", "density", "{:.4g} kg/m³");
  row("whole_damping_time_s", "total damping time of the object", "{:.3g} s");
  row("damping_time_s",
      fit.contains("whole_damping_time_s") ? "damping time in addition to the grid's dissipation" : "damping time",
      "{:.3g} s");
  row("release_s", "release", "{:.4f} s");
  row("rms_mm", "marker RMSE", "{:.3g} mm");
  row("rms_still_mm", "marker RMSE of a static object", "{:.3g} mm");
  row("rms_with_later_mm", "marker RMSE with the held-out motion", "{:.3g} mm");
  row("rms_px", "track RMSE over the fitted frames", "{:.2f} px");
  row("rms_still_px", "track RMSE of a static object", "{:.2f} px");
  row("periods", "periods in the video", "{:.1f}");
  const std::pair<const char*, const char*> spans[] = {
      {"fitted", "fitted frames"}, {"searched", "frames that only the search used"}, {"later", "held-out frames"}};
  for (const auto& [key, name] : spans) {
    const json frames = fit.value(std::string("frames_") + key, json());
    if (!frames.is_array()) continue;
    const std::string which = fmt::format("{} ({} to {})", name, frames[0].get<int>(), frames[1].get<int>());
    row((std::string("psnr_") + key).c_str(), ("PSNR of " + which).c_str(), "{:.1f} dB");
    row((std::string("still_") + key).c_str(), "PSNR of the static first frame over the same frames", "{:.1f} dB");
  }
  return "<table>\n" + rows + "</table>\n";
}

/// What each stage brought, and why it ended.
std::string steps_table(const json& fit) {
  if (!fit.contains("steps")) return "";
  std::string rows = "<tr><th>stage</th><th>track RMSE</th><th>time</th><th>steps</th><th>stopped by</th></tr>\n";
  for (const json& step : fit["steps"]) {
    const bool refined = step.contains("stopped_by");
    const std::string ended = refined ? fmt::format("<td>{}</td><td>{}{}</td>", step["loss"].size() - 1,
                                                    html_escaped(step["stopped_by"].get<std::string>()),
                                                    step["converged"].get<bool>() ? "" : " (not converged)")
                                      : "<td></td><td></td>";
    rows += fmt::format("<tr><td>{}</td><td>{:.3f} px</td><td>{:.0f} s</td>{}</tr>\n",
                        html_escaped(step["name"].get<std::string>()), step["rms_px"].get<double>(),
                        step["seconds"].get<double>(), ended);
  }
  return "<p>Stages of the fit:</p>\n<table>\n" + rows + "</table>\n";
}

}  // namespace

std::string fit_section(const RunDirectory& run) {
  const json& fit = run.summary("fit", "run `pliant fit` first");
  std::string html = numbers(fit) + steps_table(fit);
  if (fit.contains("undetermined")) {
    html += "<p>Limits of this fit:</p><ul>\n";
    for (const json& sentence : fit["undetermined"])
      html += "<li>" + html_escaped(sentence.get<std::string>()) + "</li>\n";
    html += "</ul>\n";
  }
  html += html_video(run, "fit/side_by_side.mp4", "Video, fitted motion, and their difference");
  for (int i = 2; fs::exists(run / fmt::format("fit/side_by_side_{}.mp4", i)); ++i)
    html += html_video(run, fmt::format("fit/side_by_side_{}.mp4", i),
                       fmt::format("Video {}, fitted motion, and their difference", i));
  html += html_video(run, "fit/guided.mp4", "Motion with the fitted material");
  html += html_picture(run, "fit/slices.png",
                       "Space-time slices: a line of pixels over time, in the video and in the fitted motion");
  html += html_picture(run, "fit/markers.png", "Markers: measured and simulated");
  html += html_picture(run, "fit/search.png", "Search over stiffness");
  html += html_picture(
      run, "fit/loss.png",
      "Refinement by stages: errors over all frames, although a field is first fitted to the first few frames");
  html += html_picture(run, "fit/loss_2.png", "Refinement by gradients");
  html += html_picture(run, "fit/young.png", "Young's modulus on the object");
  html += html_picture(run, "fit/uncertainty.png", "Uncertainty of Young's modulus");
  return html;
}

void clear_fit_pictures(const RunDirectory& run) {
  fs::create_directories(run / "fit");
  std::vector<fs::path> old;
  for (const auto& entry : fs::directory_iterator(run / "fit"))
    if (entry.path().extension() == ".png" || entry.path().extension() == ".mp4") old.push_back(entry.path());
  for (const fs::path& file : old) fs::remove(file);
}

void write_fit_page(const RunDirectory& run) {
  write_text(run / "fit/report.html", html_begin("Fit") + "<h1>Fit</h1>\n" + fit_section(run) + "</body></html>\n");
}

}  // namespace pliant
