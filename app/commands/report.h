#pragma once

#include <string>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// report: report.html, self-contained.
void write_report(const RunDirectory& run, const Scene& scene, const std::string& command);

}  // namespace pliant
