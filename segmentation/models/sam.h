#pragma once

#include "segmentation/model_interfaces/promptable_segmenter.h"
#include "segmentation/models/neural_module.h"
#include "segmentation/models/picture.h"

namespace pliant {

/// The SAM family (Kirillov et al. 2023; MobileSAM, SAM 2), an encoder that runs once for a picture and a decoder
/// that runs for each prompt, as export/export_sam.py, export_sam2.py and the official ONNX export write them; *never
/// run with the official weights*.  One TorchScript file with the methods "encode" and "decode", or two files with
/// "forward".
///   encoder in   image: float32 [1,3,S,S], ImageNet mean and deviation, the longest side scaled to S, upper left
///   corner,
///                the rest zero ("fit": "longest"), or both sides scaled to S ("fit": "square", SAM 2)
///           out  image_embeddings: float32 [1,256,h,w], and what else the decoder wants ("features" in the description
///                of the encoder names all, in their order)
///   decoder in   those, then point_coords: float32 [1,N,2], pixels of the scaled picture counted from their centres
///                point_labels: float32 [1,N], 0 background, 1 foreground, 2 and 3 corners of a box, -1 none: one such
///                follows points without a box, and boxes too if "pad_boxes" (SAM 2)
///                mask_input: float32 [1,1,4h,4w], has_mask_input: float32 [1], both zero
///                orig_im_size: float32 [2], height and width (an ONNX file may leave it out)
///           out  iou_predictions: float32 [1,M]; low_res_masks: float32 [1,M,4h,4w], logits.  Of M = 4 the first is
///           the
///                one mask of a clear prompt, the others are for prompts that can mean several things.
/// S is "size" of the encoder's description (1024).
class Sam : public PromptableSegmenter {
 public:
  /// `decoder` is null where one file holds both.
  Sam(std::unique_ptr<NeuralModule> encoder, std::unique_ptr<NeuralModule> decoder);

  /// What the encoder of a file of its own takes and gives.
  static Contract encoder_contract(const ModelFile& file);

  void encode(const ImageF& picture) override;
  std::vector<SegmentedMask> segment(const MaskPrompt& prompt) override;

 private:
  ImageF to_picture(const float* logits, int width, int height) const;

  std::unique_ptr<NeuralModule> encoder_, decoder_;
  Contract encode_, decode_;
  int size_ = 0;
  bool square_ = false, pads_boxes_ = false, takes_size_ = true;
  std::vector<Tensor> features_;  // of the picture
  int width_ = 0, height_ = 0;    // of the picture
  int scaled_width_ = 0, scaled_height_ = 0;
};

}  // namespace pliant
