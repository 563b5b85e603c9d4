"""SAM 2 and 2.1 (github.com/facebookresearch/sam2, commit 2b90b9f) -> TorchScript for --segmenter.  Never run with the
official weights.

The package needs torch 2.3; files of it load where libtorch is as new (CMAKE_PREFIX_PATH), else the program names what
is missing:
  python export_sam2.py --config configs/sam2.1/sam2.1_hiera_t.yaml --checkpoint sam2.1_hiera_tiny.pt --image photo.jpg --out sam2.pt
Contract: segmentation/models/sam.h, with three features and "fit": "square".
"""

import argparse

import torch
from pliant_export import compare, picture, save


class Sam2(torch.nn.Module):
    def __init__(self, model):
        super().__init__()
        self.model = model

    def encode(self, image):
        _, features, _, sizes = self.model._prepare_backbone_features(self.model.forward_image(image))
        if self.model.directly_add_no_mem_embed:
            features = features[:-1] + [features[-1] + self.model.no_mem_embed]
        fine, middle, coarse = [f.permute(1, 2, 0).reshape(1, -1, int(s[0]), int(s[1])) for f, s in zip(features, sizes)]
        return coarse, fine, middle

    def decode(self, image_embeddings, fine, middle, point_coords, point_labels, mask_input, has_mask_input, orig_im_size):
        prompts = self.model.sam_prompt_encoder
        points = prompts._embed_points(point_coords, point_labels, pad=False)
        nothing = prompts.no_mask_embed.weight.reshape(1, -1, 1, 1)
        dense = has_mask_input * prompts.mask_downscaling(mask_input) + (1 - has_mask_input) * nothing
        masks, iou, _, _ = self.model.sam_mask_decoder.predict_masks(
            image_embeddings=image_embeddings, image_pe=prompts.get_dense_pe(), sparse_prompt_embeddings=points,
            dense_prompt_embeddings=dense, repeat_image=False, high_res_features=[fine, middle])
        return iou, masks


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("config", "checkpoint", "image", "out"):
        parser.add_argument("--" + name, required=True)
    options = parser.parse_args()
    from sam2.build_sam import build_sam2
    from sam2.sam2_image_predictor import SAM2ImagePredictor

    model = build_sam2(options.config, options.checkpoint, device="cpu").eval()
    size = model.image_size
    original = Sam2(model).eval()
    with torch.no_grad():
        features = original.encode(torch.randn(1, 3, size, size))
    side = [4 * features[0].shape[2], 4 * features[0].shape[3]]
    rest = (torch.zeros(1, 1, *side), torch.zeros(1), torch.tensor([480.0, 640.0]))
    examples = features + (torch.rand(1, 3, 2) * size, torch.tensor([[1.0, 0.0, -1.0]])) + rest
    exported = save(original, {"encode": (torch.randn(1, 3, size, size),), "decode": examples}, options.out,
                    {"kind": "sam", "size": size, "fit": "square", "pad_boxes": True,
                     "features": ["image_embeddings", "high_res_feats_0", "high_res_feats_1"]})
    predictor = SAM2ImagePredictor(model)
    pixels = picture(options.image)
    predictor.set_image(pixels[0].permute(1, 2, 0).byte().numpy())
    height, width = pixels.shape[2:]
    with torch.no_grad():
        _, scores, low = predictor.predict(torch.tensor([[width / 2.0, height / 3.0]]).numpy(), torch.ones(1).numpy(), multimask_output=True)
        known = predictor._features
        place = torch.tensor([[[size / 2.0, size / 3.0], [0.0, 0.0]]])
        iou, masks = exported.decode(known["image_embed"], known["high_res_feats"][0], known["high_res_feats"][1], place,
                                     torch.tensor([[1.0, -1.0]]), *rest)
        compare("sam2, decoder", [iou[0, 1:], masks[0, 1:].clamp(-32, 32)], [torch.as_tensor(scores), torch.as_tensor(low)])
        square = torch.randn(1, 3, size, size)
        compare("sam2, encoder", exported.encode(square), original.encode(square))


if __name__ == "__main__":
    main()
