#!/usr/bin/env python3
"""Reference video from Stable Video Diffusion, for `pliant fit --video-model-cmd "python3 stable_video_diffusion.py"`.

NEVER RUN WITH THE OFFICIAL WEIGHTS: only against a stand-in of the same interface.

Protocol (fitting/observe/generate_video.h): the last argument is a folder with first.png, camera.json and request.json;
frames/0000.png and so on are written there.  Needs the Python packages torch, diffusers, transformers and accelerate, and
a GPU with about 12 GB.  The model keeps 14 frames (img2vid) or 25 (img2vid-xt); more are refused, because a second clip
that begins where the first one ends would not continue its motion.
"""

import argparse
import json
import pathlib
import sys

AREA = 1024 * 576  # pixels that the model was trained on
STEP = 64          # its sizes are multiples of this


def model_size(width, height):
    """The size nearest to the model's area with nearly the picture's shape."""
    scale = (AREA / (width * height)) ** 0.5
    return tuple(max(STEP, round(side * scale / STEP) * STEP) for side in (width, height))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--model", default="stabilityai/stable-video-diffusion-img2vid-xt")
    parser.add_argument("--most-frames", type=int, default=25)
    parser.add_argument("--motion-bucket", type=int, default=8, help="PhysDreamer used 5 or 8 for objects that swing")
    parser.add_argument("--noise-aug", type=float, default=0.02)
    parser.add_argument("--decode-chunk", type=int, default=4)
    options = parser.parse_args()

    request = json.loads((options.folder / "request.json").read_text())
    if request["protocol"] != 1:
        sys.exit(f"request.json has protocol {request['protocol']}, this script speaks 1")
    if request["frames"] > options.most_frames:
        sys.exit(f"{request['frames']} frames are asked for, the model makes at most {options.most_frames}")

    import torch
    from diffusers import StableVideoDiffusionPipeline
    from diffusers.utils import load_image

    half = torch.cuda.is_available()
    pipeline = StableVideoDiffusionPipeline.from_pretrained(
        options.model, torch_dtype=torch.float16 if half else torch.float32, variant="fp16" if half else None)
    if half:
        pipeline.enable_model_cpu_offload()

    width, height = request["width"], request["height"]
    first = load_image(str(options.folder / request["first"])).resize(model_size(width, height))
    # The model knows rates of 5 to 30 frames per second, and takes one less than the rate itself inside the pipeline.
    result = pipeline(first, width=first.size[0], height=first.size[1], num_frames=request["frames"],
                      fps=int(min(30, max(5, round(request["fps"])))), motion_bucket_id=options.motion_bucket,
                      noise_aug_strength=options.noise_aug, decode_chunk_size=options.decode_chunk,
                      generator=torch.manual_seed(request["seed"]))
    for index, frame in enumerate(result.frames[0]):
        target = options.folder / (request["write"] % index)
        target.parent.mkdir(exist_ok=True)
        frame.resize((width, height)).save(target)


if __name__ == "__main__":
    main()
