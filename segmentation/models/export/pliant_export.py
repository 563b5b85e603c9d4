"""What the export scripts share: saving, loading pictures, comparing.

TorchScript files of torch 1.13 or older load into libtorch 1.13 (Debian 12); those of newer ones may need operators or a
file format that it does not have, and the program then says which.
"""

import json
import sys

import torch

MEAN = torch.tensor([123.675, 116.28, 103.53]).reshape(1, 3, 1, 1)
DEVIATION = torch.tensor([58.395, 57.12, 57.375]).reshape(1, 3, 1, 1)


def picture(file):
    """RGB [1, 3, H, W] in 0..255."""
    import numpy
    from PIL import Image

    pixels = numpy.array(Image.open(file).convert("RGB"), dtype=numpy.float32)
    return torch.from_numpy(pixels).permute(2, 0, 1)[None]


def resized(image, height, width):
    """Linear interpolation with antialias, as PIL's."""
    return torch.nn.functional.interpolate(image, (height, width), mode="bilinear", align_corners=False, antialias=True)


def normalised(image):
    return (image - MEAN) / DEVIATION


def save(module, methods, file, description):
    """Traces `methods` {name: example inputs} of `module` and saves them with the description that the program reads."""
    module.eval()
    for parameter in module.parameters():
        parameter.requires_grad_(False)
    with torch.no_grad():
        traced = torch.jit.trace_module(module, methods, check_trace=False)
    traced.save(file, _extra_files={"pliant.json": json.dumps(description)})
    return torch.jit.load(file, map_location="cpu")


def compare(what, exported, original, tolerance=1e-3):
    """Ends the script where the exported module does not give what the original gives."""
    if torch.is_tensor(exported):
        exported, original = [exported], [original]
    for i, (a, b) in enumerate(zip(exported, original)):
        same = (a == b) | ((a - b).abs() <= tolerance * (1 + b.abs()))  # infinities are equal or not
        if a.shape != b.shape or not bool(same.all()):
            worst = (a - b).abs().max().item() if a.shape == b.shape else "%s and %s" % (list(a.shape), list(b.shape))
            sys.exit("%s: output %d differs from the original (%s)" % (what, i, worst))
    print("%s: the exported module gives what the original gives" % what)
