"""LaMa (github.com/advimman/lama, commit 786f593) -> TorchScript for --inpainter.  Never run with the official weights.

Run where the repository is importable (PYTHONPATH=lama), torch 1.8 to 1.13:
  python export_lama.py --model big-lama --image photo.jpg --out lama.pt
Contract: segmentation/models/lama.h.
"""

import argparse
import os

import torch
from pliant_export import compare, picture, save


class Lama(torch.nn.Module):
    def __init__(self, model):
        super().__init__()
        self.model = model

    def forward(self, image, mask):
        return self.model({"image": image, "mask": mask})["inpainted"].clamp(0, 1)


def load(folder):
    import yaml
    from omegaconf import OmegaConf
    from saicinpainting.training.trainers import load_checkpoint

    with open(os.path.join(folder, "config.yaml")) as text:
        config = OmegaConf.create(yaml.safe_load(text))
    config.training_model.predict_only = True
    config.visualizer.kind = "noop"
    return load_checkpoint(config, os.path.join(folder, "models", "best.ckpt"), strict=False, map_location="cpu")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("model", "image", "out"):
        parser.add_argument("--" + name, required=True)
    options = parser.parse_args()
    original = Lama(load(options.model)).eval()
    exported = save(original, {"forward": (torch.rand(1, 3, 128, 192), torch.ones(1, 1, 128, 192))}, options.out, {"kind": "lama"})
    image = picture(options.image) / 255
    image = image[:, :, : image.shape[2] // 8 * 8, : image.shape[3] // 8 * 8]
    mask = torch.zeros_like(image[:, :1])
    mask[:, :, image.shape[2] // 3 : image.shape[2] // 2, image.shape[3] // 3 : image.shape[3] // 2] = 1
    with torch.no_grad():
        compare("lama", exported(image * (1 - mask), mask), original(image * (1 - mask), mask))


if __name__ == "__main__":
    main()
