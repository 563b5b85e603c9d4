#include "app/demo/train_splats.h"

#include "gaussians/base/error.h"
#include "gaussians/reconstruct/trainer.h"

namespace pliant {

GaussianCloud train_splats(const GaussianCloud& laid, const std::vector<Camera>& cameras,
                           const std::vector<ImageU8>& photos, int iterations, uint64_t seed,
                           const Interrupted& interrupted) {
  CHECK(photos.size() == cameras.size());
  if (photos.size() < 2 || iterations == 0) return laid;
  TrainingPhotos training;
  const size_t hold_out_every = PhotoOptions{}.hold_out_every;
  for (size_t i = 0; i < photos.size(); ++i) {
    TrainingPhoto photo;
    photo.camera = cameras[i];
    photo.pixels = photos[i];
    photo.held_out = i % hold_out_every == 0;
    training.photos.push_back(std::move(photo));
  }
  TrainOptions options;
  options.iterations = iterations;
  options.seed = seed;
  options.densification = Densification::kNone;
  options.sh_degree = 0;
  options.coarse_to_fine = false;
  Trainer trainer(options, training, laid);
  while (!trainer.finished()) {
    stop_demo_if(is_interrupted(interrupted));
    trainer.step();
  }
  return trainer.state().cloud;
}

}  // namespace pliant
