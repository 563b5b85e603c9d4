#pragma once

#include <map>
#include <set>

#include "segmentation/model_interfaces/tracker.h"
#include "segmentation/models/feature_memory.h"
#include "segmentation/models/neural_module.h"
#include "segmentation/models/picture.h"

namespace pliant {

/// XMem (Cheng and Schwing 2022) and the propagation of DEVA (Cheng et al. 2023) as export/export_xmem.py writes them;
/// *never run with the official weights*.  The memory is here (feature_memory.h), a TorchScript file holds three
/// networks:
///   encode_key    frame: float32 [1,3,16h,16w], ImageNet mean and deviation, padding zero
///                 -> key [1,C,h,w], shrinkage [1,1,h,w], selection [1,C,h,w], f16 [1,*,h,w], f8 [1,*,2h,2w], f4
///                 [1,*,4h,4w]
///   encode_value  frame, f16, hidden [1,K,E,h,w], masks [1,K,16h,16w] in 0..1 -> value [1,K,V,h,w], hidden
///   segment       f16, f8, f4, readout [1,K,V,h,w], hidden, last_masks [1,K,16h,16w]
///                 -> hidden, probabilities [1,K+1,16h,16w] in 0..1, the background first
/// all float32; K things at once; E is "hidden" of the description (64).
class Xmem : public Tracker {
 public:
  struct Options {
    int short_side = 480;          ///< of larger pictures, px
    int every = 5;                 ///< frames between two that are remembered
    int frames = 10;               ///< remembered at most ...
    uint64_t memory = 2ull << 30;  ///< ... as long as their values take no more than this [B]
    int top = 30;                  ///< memory pixels that each pixel reads
    int least_pixels = 16;         ///< a thing with fewer is lost
    double correction = 0.5;       ///< above this overlap, at least .5, a detection is the thing that it lies on
  };

  Xmem(std::unique_ptr<NeuralModule> module, const Options& options);

  TrackedFrame start(const ImageF& picture, const IdImage& masks) override;
  TrackedFrame step(const ImageF& picture) override;
  TrackedFrame add(const IdImage& detections) override;

 private:
  void read_frame(const ImageF& picture);
  void remember(const Tensor& masks, bool again);
  Tensor hidden_state() const;
  void keep_hidden(const Tensor& hidden);
  Tensor masks_of(const IdImage& ids) const;
  IdImage ids_of(const Tensor& probabilities) const;
  TrackedFrame current() const;

  std::unique_ptr<NeuralModule> module_;
  Options options_;
  Contract key_, value_, segment_;
  int hidden_channels_ = 0;

  int width_ = 0, height_ = 0;                // of the pictures
  int scaled_width_ = 0, scaled_height_ = 0;  // of what the network sees, without padding
  Tensor frame_, last_masks_;
  std::vector<Tensor> features_;  // of encode_key
  FeatureMemory memory_;
  std::vector<uint32_t> things_;  // followed, in the order of their first frame
  std::map<uint32_t, std::vector<float>> hidden_;
  IdImage ids_;
  int since_memory_ = 0;
};

}  // namespace pliant
