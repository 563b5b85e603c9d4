"""SAM (github.com/facebookresearch/segment-anything, commit 6fdee8f) and MobileSAM (github.com/ChaoningZhang/MobileSAM,
commit c12dd83), which has the same interface -> TorchScript for --segmenter.  Never run with the official weights.

Run where the package is importable, torch 1.13:
  python export_sam.py --package segment_anything --type vit_b --checkpoint sam_vit_b_01ec64.pth --image photo.jpg --out sam.pt
  python export_sam.py --package mobile_sam --type vit_t --checkpoint mobile_sam.pt --image photo.jpg --out sam.pt
Contract: segmentation/models/sam.h.
"""

import argparse
import importlib

import torch
from pliant_export import compare, picture, save


class Sam(torch.nn.Module):
    def __init__(self, model):
        super().__init__()
        self.model = model

    def encode(self, image):
        return self.model.image_encoder(image)

    def decode(self, image_embeddings, point_coords, point_labels, mask_input, has_mask_input, orig_im_size):
        prompts, labels = self.model.prompt_encoder, point_labels[..., None]
        points = prompts.pe_layer._pe_encoding((point_coords + 0.5) / self.model.image_encoder.img_size)
        points = torch.where(labels == -1, prompts.not_a_point_embed.weight, points)
        for kind, table in enumerate(prompts.point_embeddings):
            points = points + (labels == kind) * table.weight
        nothing = prompts.no_mask_embed.weight.reshape(1, -1, 1, 1)
        dense = has_mask_input * prompts.mask_downscaling(mask_input) + (1 - has_mask_input) * nothing
        masks, iou = self.model.mask_decoder.predict_masks(image_embeddings=image_embeddings, image_pe=prompts.get_dense_pe(),
                                                           sparse_prompt_embeddings=points, dense_prompt_embeddings=dense)
        return iou, masks


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("checkpoint", "image", "out"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--package", default="segment_anything", choices=["segment_anything", "mobile_sam"])
    parser.add_argument("--type", default="vit_b")
    options = parser.parse_args()
    package = importlib.import_module(options.package)
    model = package.sam_model_registry[options.type](checkpoint=options.checkpoint).eval()
    size = model.image_encoder.img_size
    cells = model.prompt_encoder.image_embedding_size
    side = [4 * int(cells[0]), 4 * int(cells[1])]
    examples = (torch.randn(1, 256, *cells), torch.rand(1, 3, 2) * size, torch.tensor([[1.0, 0.0, -1.0]]), torch.zeros(1, 1, *side),
                torch.zeros(1), torch.tensor([480.0, 640.0]))
    exported = save(Sam(model), {"encode": (torch.randn(1, 3, size, size),), "decode": examples}, options.out,
                    {"kind": "sam", "size": size})

    # Against the official predictor: one point, whose three masks are ours after the first.
    pixels = picture(options.image)
    predictor = package.SamPredictor(model)
    predictor.set_image(pixels[0].permute(1, 2, 0).byte().numpy())
    height, width = pixels.shape[2:]
    coords = predictor.transform.apply_coords(torch.tensor([[width / 2.0, height / 3.0]]).numpy(), (height, width))
    place = torch.cat([torch.as_tensor(coords, dtype=torch.float32), torch.zeros(1, 2)])[None]
    with torch.no_grad():
        iou, masks = exported.decode(predictor.get_image_embedding(), place, torch.tensor([[1.0, -1.0]]), torch.zeros(1, 1, *side),
                                     torch.zeros(1), torch.tensor([float(height), float(width)]))
        _, scores, low = predictor.predict_torch(place[:, :1], torch.ones(1, 1), multimask_output=True, return_logits=True)
        compare("sam, decoder", [iou[:, 1:], masks[:, 1:]], [scores, low])
        square = torch.randn(1, 3, size, size)
        compare("sam, encoder", exported.encode(square), model.image_encoder(square))


if __name__ == "__main__":
    main()
