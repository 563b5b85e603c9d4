"""Grounding DINO (github.com/IDEA-Research/GroundingDINO, commit 856dde2) -> TorchScript for --detector.  Never run with
the official weights.

Run where the package `groundingdino` is importable, torch 1.13, transformers 4.25 to 4.40, without its CUDA operator (its
own fallback in Python is what gets traced):
  python export_grounding_dino.py --config GroundingDINO_SwinT_OGC.py --checkpoint groundingdino_swint_ogc.pth --image photo.jpg \
      --out dino.pt
Writes dino.pt and dino.txt, the vocabulary of its text encoder.  Contract: segmentation/models/grounding_dino.h.
"""

import argparse
import os

import torch
from pliant_export import compare, normalised, picture, resized, save


class Detector(torch.nn.Module):
    """The official forward with the text already in pieces."""

    def __init__(self, model, source, nested):
        super().__init__()
        self.model, self.source, self.nested = model, source, nested

    def forward(self, image, padding, input_ids, attention_mask, position_ids, token_type_ids, text_self_attention_masks):
        tokens = Tokens(input_ids=input_ids, attention_mask=attention_mask, token_type_ids=token_type_ids)
        kept = self.model.tokenizer, self.source.generate_masks_with_special_tokens_and_transfer_map
        self.model.tokenizer = lambda *_, **__: tokens
        self.source.generate_masks_with_special_tokens_and_transfer_map = lambda *_: (text_self_attention_masks, position_ids, None)
        try:
            out = self.model(self.nested(image, padding), captions=[""])
        finally:
            self.model.tokenizer, self.source.generate_masks_with_special_tokens_and_transfer_map = kept
        return out["pred_logits"], out["pred_boxes"]


class Tokens(dict):
    """What a tokenizer of transformers returns."""

    def __getattr__(self, name):
        return self[name]

    def to(self, _):
        return self


def prompt_tensors(model, make_masks, text, length):
    """The text as the program hands it over: filled up to `length` pieces."""
    tokens = model.tokenizer([text], padding="max_length", max_length=length, return_tensors="pt")
    masks, positions, _ = make_masks(tokens, model.specical_tokens, model.tokenizer)
    ids = tokens["input_ids"]
    return ids, tokens["attention_mask"].bool(), positions, torch.zeros_like(ids), masks


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("config", "checkpoint", "image", "out"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--height", type=int, default=800)
    parser.add_argument("--width", type=int, default=1200)
    parser.add_argument("--tokens", type=int, default=256)
    options = parser.parse_args()
    import groundingdino.models.GroundingDINO.groundingdino as source
    from groundingdino.models import build_model
    from groundingdino.util.misc import NestedTensor, clean_state_dict
    from groundingdino.util.slconfig import SLConfig

    config = SLConfig.fromfile(options.config)
    config.device = "cpu"
    model = build_model(config)
    model.load_state_dict(clean_state_dict(torch.load(options.checkpoint, map_location="cpu")["model"]), strict=False)
    model.eval()
    original = Detector(model, source, NestedTensor).eval()
    make_masks = source.generate_masks_with_special_tokens_and_transfer_map

    pixels = picture(options.image)
    scale = min(options.width / pixels.shape[3], options.height / pixels.shape[2])
    height, width = round(pixels.shape[2] * scale), round(pixels.shape[3] * scale)
    image = torch.zeros(1, 3, options.height, options.width)
    image[:, :, :height, :width] = normalised(resized(pixels, height, width))
    padding = torch.ones(1, options.height, options.width, dtype=torch.bool)
    padding[:, :height, :width] = False
    example = (image, padding) + prompt_tensors(model, make_masks, "chair . person .", options.tokens)
    exported = save(original, {"forward": example}, options.out,
                    {"kind": "grounding-dino", "height": options.height, "width": options.width, "tokens": options.tokens})
    vocabulary = sorted(model.tokenizer.get_vocab().items(), key=lambda entry: entry[1])
    with open(os.path.splitext(options.out)[0] + ".txt", "w", encoding="utf-8") as lines:
        lines.writelines(piece + "\n" for piece, _ in vocabulary)

    text = "red flower . table . dog ."  # another one than was traced
    inputs = (image, padding) + prompt_tensors(model, make_masks, text, options.tokens)
    with torch.no_grad():
        logits, boxes = exported(*inputs)
        compare("grounding_dino", [logits, boxes], original(*inputs))
        official = model(NestedTensor(image, padding), captions=[text])  # without filling up
        count = int(inputs[3].sum())
        compare("grounding_dino, probabilities of the official forward", logits[..., :count].sigmoid(),
                official["pred_logits"][..., :count].sigmoid(), 1e-2)


if __name__ == "__main__":
    main()
