"""RAM and RAM++ (github.com/xinyu1205/recognize-anything, commit 7cb804a) -> TorchScript for --tagger.  Never run with
the official weights.

Run where the package `ram` is importable, torch 1.13, timm 0.4.12, transformers 4.25:
  python export_ram.py --checkpoint ram_swin_large_14m.pth --image photo.jpg --out ram.pt [--plus]
Writes ram.pt and ram.txt, the tag list with its thresholds.  Contract: segmentation/models/ram.h.
"""

import argparse
import os

import torch
from pliant_export import compare, normalised, picture, resized, save


class Tagger(torch.nn.Module):
    def __init__(self, model, plus):
        super().__init__()
        self.model, self.plus = model, plus

    def labels(self, image_embeds):
        model = self.model
        if not self.plus:
            return torch.relu(model.wordvec_proj(model.label_embed))[None]
        count = model.label_embed.shape[0] // model.num_class  # descriptions of a class, weighted by the picture
        whole = torch.nn.functional.normalize(image_embeds[:, 0], dim=-1)
        weights = (model.reweight_scale.exp() * whole @ model.label_embed.t()).reshape(1, -1, count).softmax(2)
        mean = (weights[..., None] * model.label_embed.reshape(1, -1, count, model.label_embed.shape[1])).sum(2)
        return torch.relu(model.wordvec_proj(mean))

    def forward(self, image):
        model = self.model
        image_embeds = model.image_proj(model.visual_encoder(image))
        seen = torch.ones(image_embeds.shape[:-1], dtype=torch.long)
        tagged = model.tagging_head(encoder_embeds=self.labels(image_embeds), encoder_hidden_states=image_embeds,
                                    encoder_attention_mask=seen, return_dict=False, mode="tagging")
        return model.fc(tagged[0]).squeeze(-1)


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("checkpoint", "image", "out"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--plus", action="store_true", help="the checkpoint is of RAM++")
    parser.add_argument("--size", type=int, default=384)
    options = parser.parse_args()
    from ram.models import ram, ram_plus

    model = (ram_plus if options.plus else ram)(pretrained=options.checkpoint, image_size=options.size, vit="swin_l").eval()
    original = Tagger(model, options.plus).eval()
    image = normalised(resized(picture(options.image), options.size, options.size))
    exported = save(original, {"forward": (torch.randn(1, 3, options.size, options.size),)}, options.out,
                    {"kind": "ram", "size": options.size})
    with open(os.path.splitext(options.out)[0] + ".txt", "w", encoding="utf-8") as lines:
        for name, threshold in zip(model.tag_list, model.class_threshold):
            lines.write("%s\t%.4f\n" % (name, float(threshold)))
    with torch.no_grad():
        logits = exported(image)
        compare("ram", logits, original(image))
        names = [str(name) for name, on in zip(model.tag_list, logits.sigmoid()[0] > model.class_threshold) if on]
        official = model.generate_tag(image)[0][0]
        compare("ram, tags of generate_tag", torch.tensor([float(" | ".join(names) == official)]), torch.ones(1))


if __name__ == "__main__":
    main()
