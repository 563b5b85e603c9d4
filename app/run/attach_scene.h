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

/// Says what is doubtful about a scene.
void warn_of_scene(const Context& context, const Scene& scene);

/// Throws Error{kUsage} for an option that did nothing when this scene was loaded.
void refuse_unused(const LoadOptions& options, const Scene& scene);

/// Sets metres_per_unit of a scene by its object_height, where that is known and the object is extracted.
void scale_to_height(const RunDirectory& run, Scene& scene);
/// The same, by the height that was assumed of the object where none is given.
void scale_by_object(const RunDirectory& run, Scene& scene);
/// What `predict` took the height of the extracted object to be [m]; none where nothing, or another object's, was
/// assumed.
std::optional<double> assumed_height(const RunDirectory& run);
/// Records such a height of the extracted object; none erases what is recorded.
void record_assumed_height(RunDirectory& run, const std::optional<double>& metres);
/// Without what `predict` took the object's height to be, where that was assumed.
void forget_assumed_height(RunDirectory& run, Scene& scene);

/// By what the extracted object is known again: {object: its folder, splats, segmentation: hashes, where they are
/// there}.
nlohmann::json identity_of_object(const RunDirectory& run);
/// Whether the extracted object is that of this identity, perhaps renamed, or cut otherwise from the same objects.
bool is_present_object(const RunDirectory& run, const nlohmann::json& identity);
/// Whether objects were found or edited since one was extracted; names alone do not count.
bool is_selected_anew(const RunDirectory& run);
/// Says so, for a command that goes on with the object that is extracted.
void warn_of_selection(const Context& context, const RunDirectory& run);

/// Folder of the extracted object, relative to the run directory.
std::string object_folder(const RunDirectory& run);

/// Those of these values that `extract` found: name, height [scene units], contact {support, point, normal, band}.
nlohmann::json extracted(const RunDirectory& run, const std::vector<std::string>& names);

/// Whether a stage that has run read the file `role`.h5 ("object": object.ply) of the object as it is now, or none of
/// that name.
bool reads_present(const RunDirectory& run, const std::string& stage, const std::string& role);

/// Whether the prediction of this run is of the object that is extracted, as it is now.
bool predicts_object(const RunDirectory& run);
/// What the prediction of this run does not belong to any more: "of another object", "made with another scale"; empty
/// when it belongs to what is there.
std::string prediction_is_of(const RunDirectory& run, const Scene& scene);
/// What of E, nu and rho in the scene file has changed since it was predicted with, as a sentence; empty for nothing.
std::string changed_since_prediction(const RunDirectory& run, const Scene& scene);

/// Whether this run has been fitted.
bool is_fitted(const RunDirectory& run);
/// Whether a fit that is to replace that of this run was interrupted, and so neither is there.
bool is_refit_unfinished(const RunDirectory& run);
/// What the fit of this run does not belong to any more: "other particles", "another scale"; empty when it belongs to
/// what is there.
std::string fit_is_of(const RunDirectory& run, const Scene& scene);
/// Throws Error{kUsage} where nothing is filled with samples, or another object than the extracted one as it is now.
void check_filled(const RunDirectory& run);
/// Whether the particles are of the extracted object as it is now; true as well where there is no record of them.
bool seeds_object(const RunDirectory& run);
/// Throws Error{kUsage} where there are no particles, or they are of another object.
void check_seeded(const RunDirectory& run);
/// Throws Error{kUsage} where the simulated motion is of another object, or of other particles than those that are
/// there.
void check_simulated(const RunDirectory& run);
/// Likewise where it is of another material or scale, with which nobody could go on moving the object.
void check_simulated_with(const RunDirectory& run, const Scene& scene);

}  // namespace pliant
