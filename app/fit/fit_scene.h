#pragma once

#include <memory>

#include "app/fit/fit_stage.h"
#include "app/fit/start_material.h"
#include "app/import/interactions.h"
#include "app/simulate/simulated_body.h"
#include "fitting/objective/picture_loss.h"
#include "fitting/objective/track_loss.h"
#include "fitting/observe/reference_video.h"

namespace pliant {

/// A reference video, and what its camera sees of the scene at rest.
struct FitView {
  ReferenceVideo video;
  std::vector<ImageU8> compared;       ///< [T], [1] or none, [H, W, 1] each: 0 where a pixel is not compared
  ImageF still;                        ///< [H, W, 3] the scene at rest
  ImageF moving;                       ///< [H, W, 1] share of what can move in a pixel
  ImageU8 mask;                        ///< [H, W, 1] not 0 where most of a pixel can
  std::vector<Vec3f> points;           ///< [K, 3] scene units, of visible surface that can move
  std::vector<Eigen::Vector2d> pixel;  ///< [K] where they are seen at rest
  double displaced = 0;                ///< px, of the object in the first frame from rest where that counts, else 0
};

/// The object that a fit is about, and the videos of it; the first is this view itself.
struct FitScene : FitView {
  std::vector<FitView> further;  ///< of other cameras at the same time, with the first's frames a second
  int used = 0;                  ///< frames that the fit may see; later ones judge it
  double free_after = -1;        ///< s after the first frame, from which on nothing pushes; negative: to be found
  StartMaterial start;
  SimulatedBody body;             ///< with that material
  std::vector<Interaction> pins;  ///< or, where nothing holds the body, the floor that carries it
  std::shared_ptr<DrawnObject<float>> drawn;

  /// Each view, the first one first.
  std::vector<const FitView*> views() const;
};

/// `run` is where found cameras and generated videos are written to.
FitScene load_fit_scene(const Context& context, const RunDirectory& run, const FitInputs& in);

/// The same without a video, before `camera`.
FitScene load_still_scene(const Context& context, const FitInputs& in, const Camera& camera);

constexpr double kTrackOutlier = 3;  ///< px of a track's error beyond which it counts less and less

/// The points of all views followed through the frames that may be used, from the first on or, where that shows the
/// object displaced, from the scene at rest.  Throws Error{kInput} when too few can be
/// followed.
PointTracks follow_points(const Context& context, const FitScene& fit);

/// Parts of the body that may be of different materials, [drivers]: `count` patches by place and colour, joined where
/// they look alike (fitting/fit/parts.h).
std::vector<uint32_t> parts_of(const FitScene& fit, int count);
/// The same by labels of the scene's Gaussians in `file` (labels.h5 or segmentation.h5): of most of what a driver
/// moves.
std::vector<uint32_t> labelled_parts(const FitScene& fit, const Scene& scene, const std::string& file);

/// Whether a pixel of a frame is compared; outside the picture none is.
bool is_compared(const FitView& view, int frame, double x, double y);

/// `mask` [H, W, 1] becomes 0 where pixels of that frame are not compared.
void leave_out(ImageF& mask, const FitView& view, int frame);

/// [H, W, 1]: 1 where anything moves in some of the video's first `frames` frames, grown by `grow` pixels; see
/// `moving`.  Pixels that are not compared tell no motion.
ImageF motion_mask(const FitView& view, int frames, int grow);

}  // namespace pliant
