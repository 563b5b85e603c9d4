#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// Where a scene is, through no link to a folder.  A link to a file stays one: what belongs to the splats lies beside
/// it.
std::filesystem::path place_of_scene(const std::filesystem::path& source);

/// Where the scene of a run directory is, by its record.
std::filesystem::path recorded_place(const RunDirectory& run);
/// The options that it was loaded with.
LoadOptions recorded_options(const RunDirectory& run);
/// Whether `source` is, or links to, what a run directory records as its scene.
bool is_recorded_scene(const RunDirectory& run, const std::filesystem::path& source);

/// Loads the scene that a run directory was made from; an Error{kInput} says what to do where it is no longer there.
Scene load_run_scene(const RunDirectory& run);
/// Records `source` in the run directory and loads it.  A scene elsewhere with the same splats, which may be a
/// file of another name, is the same scene, which has moved.
Scene attach_scene(const Context& context, RunDirectory& run, const std::filesystem::path& source,
                   const LoadOptions& options);

/// Throws Error{kUsage} for an option that did nothing when this scene was loaded.
void refuse_unused(const LoadOptions& options, const Scene& scene);

/// Sets metres_per_unit of a scene by the height of its object, where that is given, or assumed, and the object is
/// extracted.
void scale_by_object(const RunDirectory& run, Scene& scene);
/// What `predict` took the height of the extracted object to be [m]; none where nothing, or another object's, was
/// assumed.
std::optional<double> assumed_height(const RunDirectory& run);
/// Records such a height of the extracted object; none erases what is recorded.
void record_assumed_height(RunDirectory& run, const std::optional<double>& metres);
/// Without what `predict` took the object's height to be, where that was assumed.
void forget_assumed_height(RunDirectory& run, Scene& scene);

/// Folder of the extracted object, relative to the run directory.
std::string object_folder(const RunDirectory& run);

/// Those of these values that `extract` found: name, height [scene units], contact {support, point, normal, band}.
nlohmann::json extracted(const RunDirectory& run, const std::vector<std::string>& names);

/// Whether a stage that has run read the file `role`.h5 of the object as it is now, or none of that name.
bool reads_present(const RunDirectory& run, const std::string& stage, const std::string& role);

/// Whether the prediction of this run is of the object that is extracted.
bool predicts_object(const RunDirectory& run);

/// Whether this run has been fitted.
bool is_fitted(const RunDirectory& run);
/// Whether a fit that is to replace that of this run was interrupted, and so neither is there.
bool is_refit_unfinished(const RunDirectory& run);
/// What the fit of this run does not belong to any more: "other particles", "another scale"; empty when it belongs to
/// what is there.
std::string fit_is_of(const RunDirectory& run, const Scene& scene);
/// Throws Error{kUsage} where the simulated motion is of other particles than those that are there.
void check_simulated(const RunDirectory& run);
/// Likewise where it is of another material or scale, with which nobody could go on moving the object.
void check_simulated_with(const RunDirectory& run, const Scene& scene);

}  // namespace pliant
