#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "app/demo/reference.h"
#include "app/demo/splats.h"
#include "app/store/trajectory.h"

namespace pliant {

/// truth/labels.h5: the id of each Gaussian.  NAME: the part of each, 1 + its material, 0 elsewhere.
void write_label_truth(const std::filesystem::path& folder, const char* parts_name, const Stage& stage,
                       const StageSplats& splats, uint64_t seed);
/// truth/flower.json: proportions and elastic constants of the flower.
void write_flower_truth(const std::filesystem::path& folder, const Flower& flower, uint64_t seed);
/// truth/object.json: kind, seed, and of each part volume, mass, elastic constants, the band that they were drawn from
/// and the reason for it.
void write_object_truth(const std::filesystem::path& folder, const std::string& kind, const DemoObject& object,
                        const ReferenceBody& body, uint64_t seed);
/// truth/material.h5: the elastic constants of the body's samples.
void write_material_truth(const std::filesystem::path& folder, const ReferenceBody& body, uint64_t seed);

/// A reference motion: interactions.json, trajectory.h5 (as much of it as is given) and video_motion.json (place of the
/// object's tip in each frame).
void write_motion_truth(const std::filesystem::path& folder, const ReferenceMotion& motion,
                        const TrajectoryFile& trajectory, const ReferenceFilm& film, const Camera& camera,
                        uint64_t seed);

/// The motion as a trajectory, of every `every`-th particle.
TrajectoryFile trajectory_of(const ReferenceMotion& motion, const std::string& name, size_t every = 1);
/// As read from an interactions.json.
nlohmann::ordered_json interactions_json(const std::vector<Interaction>& interactions);

/// What is behind the object.  Ids of hidden/NAME.png.
enum HiddenId : uint32_t {
  kInPlainView = 0,    ///< the photo does not show the object here
  kSeenElsewhere = 1,  ///< another photo shows the surface that the object hides here
  kNeverSeen = 2,      ///< no photo does
};

/// The stage without the object: without_object/NAME.png is its photo and hidden/NAME.png says which of its pixels the
/// given photos have never shown (HiddenId, at pixel centres).
void write_hidden_truth(const std::filesystem::path& folder, const Stage& stage, const std::vector<Camera>& cameras);

}  // namespace pliant
