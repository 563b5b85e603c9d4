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
  row("young_before_pa", "the same before", "{:.4g} Pa");
  row("log10_sigma", "one standard deviation by noise alone", "{:.3f} decades");
  row("poisson", "Poisson's ratio", "{:.3f}");
  row("whole_damping_time_s", "damping time, the object's own", "{:.3g} s");
  row("damping_time_s",
      fit.contains("whole_damping_time_s") ? "the same beside what the solver's grid takes" : "damping time",
      "{:.3g} s");
  row("release_s", "release", "{:.4f} s");
  row("rms_mm", "markers off by", "{:.3g} mm");
  row("rms_with_later_mm", "the same with as much again that the fit did not see", "{:.3g} mm");
  row("rms_px", "points off by", "{:.2f} px");
  row("rms_still_px", "the same if nothing moved", "{:.2f} px");
  row("periods", "periods in the video", "{:.1f}");
  row("psnr_used", "frames that the fit saw", "{:.1f} dB");
  if (fit.value("frames_later", 0) > 0) {
    row("psnr_later", "later frames", "{:.1f} dB");
    row("still_later", "the first frame held, against the later ones", "{:.1f} dB");
  }
  return "<table>\n" + rows + "</table>\n";
}

/// What each stage brought, and why it ended.
std::string steps_table(const json& fit) {
  if (!fit.contains("steps")) return "";
  std::string rows = "<tr><th>stage</th><th>points off by</th><th>time</th><th>steps</th><th>ended by</th></tr>\n";
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
  return "<p>What each stage brought:</p>\n<table>\n" + rows + "</table>\n";
}

}  // namespace

std::string fit_section(const RunDirectory& run) {
  const json& fit = run.summary("fit", "run `pliant fit` first");
  std::string html = numbers(fit) + steps_table(fit);
  if (fit.contains("undetermined")) {
    html += "<p>What this does not determine:</p><ul>\n";
    for (const json& sentence : fit["undetermined"])
      html += "<li>" + html_escaped(sentence.get<std::string>()) + "</li>\n";
    html += "</ul>\n";
  }
  html += html_video(run, "fit/side_by_side.mp4", "The video, the fitted motion, their difference");
  for (int i = 2; fs::exists(run / fmt::format("fit/side_by_side_{}.mp4", i)); ++i)
    html += html_video(run, fmt::format("fit/side_by_side_{}.mp4", i), fmt::format("The same of video {}", i));
  html += html_video(run, "fit/guided.mp4", "The motion with what was found");
  html += html_picture(run, "fit/slices.png",
                       "Space-time slices: a line of pixels over time, in the video and in the fitted motion");
  html += html_picture(run, "fit/markers.png", "Markers: measured and simulated");
  html += html_picture(run, "fit/search.png", "The search over stiffness");
  html += html_picture(
      run, "fit/loss.png",
      "The refinement, stage by stage: errors over all frames, though a field is fitted to the first few frames first");
  html += html_picture(run, "fit/loss_2.png", "The same of gradients");
  html += html_picture(run, "fit/young.png", "Young's modulus on the object");
  html += html_picture(run, "fit/uncertainty.png", "How well it is known");
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
