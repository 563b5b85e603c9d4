"""XMem (github.com/hkchengrex/XMem, commit 083698b) and DEVA (github.com/hkchengrex/Tracking-Anything-with-DEVA, commit
2aafa2f) -> TorchScript for --tracker.  Never run with the official weights.

Run where the repository is importable (PYTHONPATH=XMem, or the package `deva`), torch 1.13:
  python export_xmem.py --checkpoint XMem.pth --image photo.jpg --out xmem.pt
  python export_xmem.py --deva --checkpoint DEVA-propagation.pth --image photo.jpg --out deva.pt
Contract: segmentation/models/xmem.h.  The licence of DEVA's code and weights forbids commercial use.
"""

import argparse

import torch
from pliant_export import compare, normalised, picture, resized, save


class XMem(torch.nn.Module):
    def __init__(self, network):
        super().__init__()
        self.network = network

    def encode_key(self, frame):
        return self.network.encode_key(frame)

    def encode_value(self, frame, f16, hidden, masks):
        others = masks.sum(1, keepdim=True) - masks  # of the official code, for any number of things
        return self.network.value_encoder(frame, f16, hidden, masks, others, True)

    def segment(self, f16, f8, f4, readout, hidden, last_masks):
        hidden, _, probabilities = self.network.segment((f16, f8, f4), readout, hidden, h_out=True, strip_bg=False)
        return hidden, probabilities


class Deva(XMem):
    def encode_key(self, frame):
        (f16, f8, f4), feature = self.network.encode_image(frame)
        key, shrinkage, selection = self.network.transform_key(feature)
        return key, shrinkage, selection, f16, f8, f4

    def encode_value(self, frame, f16, hidden, masks):
        return self.network.encode_mask(frame, (f16,), hidden, masks, is_deep_update=True)

    def segment(self, f16, f8, f4, readout, hidden, last_masks):
        hidden, _, probabilities = self.network.segment((f16, f8, f4), readout, hidden, last_masks, update_sensory=True)
        return hidden, probabilities


def load(options):
    if options.deva:
        from deva.model.network import DEVA

        network = DEVA({"pix_feat_dim": 512, "key_dim": 64, "value_dim": 512})
        network.load_weights(torch.load(options.checkpoint, map_location="cpu"))
        return Deva(network), 512
    from model.network import XMem as Network

    network = Network({}, options.checkpoint)
    return XMem(network), network.hidden_dim


def chain(module, frame, masks, channels):
    """All three methods, one after the other."""
    key, shrinkage, selection, f16, f8, f4 = module.encode_key(frame)
    hidden = torch.zeros(1, masks.shape[1], channels, *f16.shape[2:])
    value, hidden = module.encode_value(frame, f16, hidden, masks)
    return (key, shrinkage, selection, value, hidden) + tuple(module.segment(f16, f8, f4, value, hidden, masks))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    for name in ("checkpoint", "image", "out"):
        parser.add_argument("--" + name, required=True)
    parser.add_argument("--deva", action="store_true")
    options = parser.parse_args()
    original, channels = load(options)
    original.eval()
    frame, masks = torch.randn(1, 3, 128, 160), torch.rand(1, 2, 128, 160)
    with torch.no_grad():
        key = original.encode_key(frame)
        hidden = torch.zeros(1, 2, channels, 8, 10)
        value, _ = original.encode_value(frame, key[3], hidden, masks)
    exported = save(original, {"encode_key": (frame,), "encode_value": (frame, key[3], hidden, masks),
                               "segment": (key[3], key[4], key[5], value, hidden, masks)}, options.out,
                    {"kind": "xmem", "hidden": channels})
    image = normalised(picture(options.image))
    image = resized(image, max(image.shape[2] // 16, 1) * 16, max(image.shape[3] // 16, 1) * 16)
    for count in (1, 2, 3):  # also numbers of things that were not traced
        masks = torch.zeros(1, count, *image.shape[2:])
        for k in range(count):
            masks[:, k, 16 * k : 16 * k + 16] = 1
        with torch.no_grad():
            compare("xmem, %d things" % count, chain(exported, image, masks, channels), chain(original, image, masks, channels))
            if not options.deva:
                hidden = torch.zeros(1, count, channels, image.shape[2] // 16, image.shape[3] // 16)
                f16 = original.encode_key(image)[3]
                compare("xmem, values of the official code", original.encode_value(image, f16, hidden, masks),
                        original.network.encode_value(image, f16, hidden, masks))


if __name__ == "__main__":
    main()
