"""Runs every script of segmentation/models/export on tiny stand-ins with the interface of the official packages:
  export_check.py FOLDER_OF_THE_SCRIPTS OUT [NAME...]
"""

import importlib
import os
import sys
import types

try:
    import numpy
    import torch
except ImportError:
    sys.exit(77)
from torch import nn
from torch.nn import functional as F

torch.manual_seed(1)
torch.set_num_threads(1)


def package(name, **members):
    """A module that `import` finds."""
    parts = name.split(".")
    for i in range(1, len(parts) + 1):
        known = sys.modules.setdefault(".".join(parts[:i]), types.ModuleType(".".join(parts[:i])))
        if i > 1:
            setattr(sys.modules[".".join(parts[: i - 1])], parts[i - 1], known)
    for key, value in members.items():
        setattr(sys.modules[name], key, value)


def run(name, *arguments):
    sys.argv = [name] + list(arguments)
    importlib.import_module(name).main()


def lama(picture, out):
    class Model(nn.Module):
        def __init__(self):
            super().__init__()
            self.layer = nn.Conv2d(4, 3, 3, padding=1, padding_mode="reflect")

        def forward(self, batch):
            image = batch["image"] * (1 - batch["mask"])
            spectrum = torch.fft.irfftn(torch.fft.rfftn(image, dim=(-2, -1)), s=image.shape[-2:], dim=(-2, -1))
            filled = self.layer(torch.cat([spectrum, batch["mask"]], 1)).sigmoid()
            batch["inpainted"] = batch["mask"] * filled + (1 - batch["mask"]) * batch["image"]
            return batch

    importlib.import_module("export_lama").load = lambda folder: Model()
    run("export_lama", "--model", "big-lama", "--image", picture, "--out", out + "/lama.pt")


def ram(picture, out):
    class Model(nn.Module):
        def __init__(self):
            super().__init__()
            self.tag_list = numpy.array(["rose", "grass", "sky"])
            self.class_threshold = torch.tensor([0.5, 0.4, 0.6])
            self.num_class = 3
            self.label_embed = nn.Parameter(torch.randn(3, 8))
            self.wordvec_proj, self.image_proj, self.fc = nn.Linear(8, 16), nn.Linear(3, 8), nn.Linear(16, 1)
            self.look = nn.Linear(8, 16)

        def visual_encoder(self, image):
            cells = F.adaptive_avg_pool2d(image, 4).flatten(2).transpose(1, 2)
            return torch.cat([cells.mean(1, keepdim=True), cells], 1)

        def tagging_head(self, encoder_embeds, encoder_hidden_states, encoder_attention_mask, return_dict, mode):
            seen = (self.look(encoder_hidden_states) * encoder_attention_mask[..., None]).mean(1, keepdim=True)
            return (encoder_embeds + seen,)

        def generate_tag(self, image):
            hidden = self.image_proj(self.visual_encoder(image))
            labels = torch.relu(self.wordvec_proj(self.label_embed))[None]
            logits = self.fc(self.tagging_head(labels, hidden, torch.ones(hidden.shape[:-1]), False, "tagging")[0]).squeeze(-1)
            on = (logits.sigmoid()[0] > self.class_threshold).numpy()
            return [" | ".join(self.tag_list[on])], [""]

    class Plus(Model):
        """Four descriptions of each name, weighted by how well they fit the picture."""

        def __init__(self):
            super().__init__()
            self.label_embed = nn.Parameter(torch.randn(12, 8))
            self.reweight_scale = nn.Parameter(torch.tensor(0.5))
            self.class_threshold = torch.tensor([0.45, 0.5, 0.55])

        def generate_tag(self, image):
            hidden = self.image_proj(self.visual_encoder(image))
            whole = hidden[0, 0] / hidden[0, 0].norm()
            labels = torch.empty(1, 3, 8)
            for k, descriptions in enumerate(self.label_embed.view(3, 4, 8)):
                weights = (self.reweight_scale.exp() * descriptions @ whole).softmax(0)
                labels[0, k] = (weights[:, None] * descriptions).sum(0)
            labels = torch.relu(self.wordvec_proj(labels))
            self.logits = self.fc(self.tagging_head(labels, hidden, torch.ones(hidden.shape[:-1]), False, "tagging")[0]).squeeze(-1)
            return [" | ".join(self.tag_list[(self.logits.sigmoid()[0] > self.class_threshold).numpy()])], [""]

    plus = Plus()
    package("ram.models", ram=lambda **_: Model(), ram_plus=lambda **_: plus)
    run("export_ram", "--checkpoint", "-", "--image", picture, "--out", out + "/ram.pt", "--size", "32")
    run("export_ram", "--checkpoint", "-", "--image", picture, "--out", out + "/ram_plus.pt", "--size", "32", "--plus")
    image = torch.rand(1, 3, 32, 32)
    with torch.no_grad():
        plus.generate_tag(image)
        torch.testing.assert_close(torch.jit.load(out + "/ram_plus.pt")(image), plus.logits)


class PositionalEncoding(nn.Module):
    def __init__(self):
        super().__init__()
        self.register_buffer("matrix", torch.randn(2, 128))

    def _pe_encoding(self, coords):
        turned = (2 * coords - 1) @ self.matrix * 6.283185
        return torch.cat([turned.sin(), turned.cos()], -1)


class MaskDecoder(nn.Module):
    def __init__(self):
        super().__init__()
        self.up = nn.ConvTranspose2d(256, 4, 4, stride=4)
        self.score = nn.Linear(256, 4)

    def predict_masks(self, image_embeddings, image_pe, sparse_prompt_embeddings, dense_prompt_embeddings, **high):
        told = sparse_prompt_embeddings.mean(1)
        masks = self.up(image_embeddings + image_pe + dense_prompt_embeddings + told[..., None, None])
        for feature in high.get("high_res_features", []):
            masks = masks + F.interpolate(feature.mean(1, keepdim=True), size=masks.shape[2:])
        if high:
            return masks, self.score(told), None, None
        return masks, self.score(told)


class PromptEncoder(nn.Module):
    def __init__(self, cells):
        super().__init__()
        self.image_embedding_size = (cells, cells)
        self.pe_layer = PositionalEncoding()
        self.point_embeddings = nn.ModuleList(nn.Embedding(1, 256) for _ in range(4))
        self.not_a_point_embed, self.no_mask_embed = nn.Embedding(1, 256), nn.Embedding(1, 256)
        self.mask_downscaling = nn.Conv2d(1, 256, 4, stride=4)
        self.size = 16 * cells

    def get_dense_pe(self):
        cells = self.image_embedding_size[0]
        grid = (torch.arange(cells) + 0.5) / cells
        place = torch.stack([grid[None, :].expand(cells, cells), grid[:, None].expand(cells, cells)], -1)
        return self.pe_layer._pe_encoding(place).permute(2, 0, 1)[None]

    def _embed_points(self, points, labels, pad):
        points = points + 0.5
        if pad:
            points = torch.cat([points, torch.zeros(points.shape[0], 1, 2)], 1)
            labels = torch.cat([labels, -torch.ones(labels.shape[0], 1)], 1)
        encoded = self.pe_layer._pe_encoding(points / self.size)
        encoded = torch.where(labels[..., None] == -1, self.not_a_point_embed.weight, encoded)
        for kind, table in enumerate(self.point_embeddings):
            encoded = encoded + (labels[..., None] == kind) * table.weight
        return encoded


class Encoder(nn.Module):
    img_size = 64

    def __init__(self):
        super().__init__()
        self.layer = nn.Conv2d(3, 256, 16, stride=16)

    def forward(self, image):
        return self.layer(image)


def sam(picture, out):
    class Model(nn.Module):
        def __init__(self):
            super().__init__()
            self.image_encoder, self.prompt_encoder, self.mask_decoder = Encoder(), PromptEncoder(4), MaskDecoder()

    class Transform:
        def apply_coords(self, coords, size):
            return coords * 64 / max(size)

    class Predictor:
        def __init__(self, model):
            self.model, self.transform = model, Transform()

        def set_image(self, pixels):
            image = torch.from_numpy(pixels).float().permute(2, 0, 1)[None]
            self.embedding = self.model.image_encoder(F.interpolate(image, (64, 64)))

        def get_image_embedding(self):
            return self.embedding.detach()

        def predict_torch(self, coords, labels, multimask_output, return_logits):
            model = self.model
            points = model.prompt_encoder._embed_points(coords, labels, pad=True)
            dense = model.prompt_encoder.no_mask_embed.weight.reshape(1, -1, 1, 1)
            low, iou = model.mask_decoder.predict_masks(self.embedding, model.prompt_encoder.get_dense_pe(), points, dense)
            return low[:, 1:] > 0, iou[:, 1:], low[:, 1:]

    package("segment_anything", sam_model_registry={"vit_b": lambda checkpoint: Model()}, SamPredictor=Predictor)
    run("export_sam", "--checkpoint", "-", "--image", picture, "--out", out + "/sam.pt")
    package("mobile_sam", sam_model_registry={"vit_t": lambda checkpoint: Model()}, SamPredictor=Predictor)
    run("export_sam", "--package", "mobile_sam", "--type", "vit_t", "--checkpoint", "-", "--image", picture, "--out", out + "/mobile_sam.pt")


def sam2(picture, out):
    class Model(nn.Module):
        image_size, directly_add_no_mem_embed = 64, True

        def __init__(self):
            super().__init__()
            self.coarse, self.fine, self.middle = Encoder(), nn.Conv2d(3, 32, 4, stride=4), nn.Conv2d(3, 64, 8, stride=8)
            self.no_mem_embed = nn.Parameter(torch.randn(1, 1, 256))
            self.sam_prompt_encoder, self.sam_mask_decoder = PromptEncoder(4), MaskDecoder()

        def forward_image(self, image):
            return [self.fine(image), self.middle(image), self.coarse(image)]

        def _prepare_backbone_features(self, features):
            return None, [f.flatten(2).permute(2, 0, 1) for f in features], None, [f.shape[2:] for f in features]

    class Predictor:
        def __init__(self, model):
            self.model = model

        def set_image(self, pixels):
            image = F.interpolate(torch.from_numpy(pixels).float().permute(2, 0, 1)[None], (64, 64))
            self.size = pixels.shape[:2]
            fine, middle, coarse = self.model.forward_image(image)
            self._features = {"image_embed": coarse + self.model.no_mem_embed.reshape(1, -1, 1, 1), "high_res_feats": [fine, middle]}

        def predict(self, coords, labels, multimask_output):
            scaled = torch.as_tensor(coords)[None] * 64 / torch.tensor([self.size[1], self.size[0]])
            points = self.model.sam_prompt_encoder._embed_points(scaled.float(), torch.as_tensor(labels)[None], pad=True)
            dense = self.model.sam_prompt_encoder.no_mask_embed.weight.reshape(1, -1, 1, 1)
            low, iou, _, _ = self.model.sam_mask_decoder.predict_masks(
                self._features["image_embed"], self.model.sam_prompt_encoder.get_dense_pe(), points, dense,
                high_res_features=self._features["high_res_feats"])
            return None, iou[0, 1:].numpy(), low[0, 1:].clamp(-32, 32).numpy()

    package("sam2.build_sam", build_sam2=lambda config, checkpoint, device: Model())
    package("sam2.sam2_image_predictor", SAM2ImagePredictor=Predictor)
    run("export_sam2", "--config", "-", "--checkpoint", "-", "--image", picture, "--out", out + "/sam2.pt")


def grounding_dino(picture, out):
    vocabulary = ["[PAD]", "[UNK]", "[CLS]", "[SEP]", ".", "red", "flower", "table", "dog", "chair", "person"]

    class Tokenizer:
        def __call__(self, texts, padding="longest", max_length=0, return_tensors="pt"):
            ids = [2] + [vocabulary.index(word) for word in texts[0].split()] + [3]
            length = max_length if padding == "max_length" else len(ids)
            mask = [1] * len(ids) + [0] * (length - len(ids))
            ids = ids + [0] * (length - len(ids))
            entries = dict(input_ids=ids, attention_mask=mask, token_type_ids=[0] * length)
            return sys.modules["export_grounding_dino"].Tokens({key: torch.tensor([value]) for key, value in entries.items()})

        def get_vocab(self):
            return {word: i for i, word in enumerate(vocabulary)}

    def make_masks(tokens, special, tokenizer):
        ids = tokens["input_ids"][0].tolist()
        masks, positions, begin = torch.eye(len(ids)).bool()[None], torch.zeros(1, len(ids), dtype=torch.long), 0
        for end, piece in enumerate(ids):
            if piece in (2, 3, 4):
                masks[:, begin : end + 1, begin : end + 1] = True
                positions[0, begin : end + 1] = torch.arange(end + 1 - begin)
                begin = end + 1
        return masks, positions, None

    class Nested:
        def __init__(self, tensors, mask):
            self.tensors, self.mask, self.device = tensors, mask, "cpu"

    class Model(nn.Module):
        def __init__(self):
            super().__init__()
            self.tokenizer, self.specical_tokens = Tokenizer(), [2, 3, 4]
            self.words, self.places = nn.Embedding(len(vocabulary), 8), nn.Embedding(256, 8)
            self.look, self.box = nn.Linear(3, 5 * 8), nn.Linear(3, 5 * 4)

        def load_state_dict(self, state, strict):
            pass

        def forward(self, samples, captions):
            tokens = self.tokenizer(captions, padding="longest", return_tensors="pt").to(samples.device)
            source = sys.modules["groundingdino.models.GroundingDINO.groundingdino"]
            masks, positions, _ = source.generate_masks_with_special_tokens_and_transfer_map(tokens, self.specical_tokens, self.tokenizer)
            text = self.words(tokens["input_ids"]) + self.places(positions) + tokens["token_type_ids"][..., None]
            text = (masks.float() / masks.float().sum(2, keepdim=True)) @ text
            seen = (samples.tensors * ~samples.mask[:, None]).mean((2, 3))
            logits = self.look(seen).reshape(1, 5, 8) @ text.transpose(1, 2)
            padding = ~tokens["attention_mask"].bool()[:, None]
            # Every piece has a probability above 0.7, so that a detector finds something.
            logits = logits + 1 - logits.masked_fill(padding, float("inf")).amin()
            logits = logits.masked_fill(padding, float("-inf"))
            return {"pred_logits": logits, "pred_boxes": self.box(seen).reshape(1, 5, 4).sigmoid()}

    package("groundingdino.models", build_model=lambda config: Model())
    package("groundingdino.models.GroundingDINO.groundingdino", generate_masks_with_special_tokens_and_transfer_map=make_masks)
    package("groundingdino.util.misc", NestedTensor=Nested, clean_state_dict=lambda state: state)
    package("groundingdino.util.slconfig", SLConfig=types.SimpleNamespace(fromfile=lambda file: types.SimpleNamespace()))
    torch.save({"model": {}}, out + "/empty.pth")
    run("export_grounding_dino", "--config", "-", "--checkpoint", out + "/empty.pth", "--image", picture, "--out", out + "/dino.pt",
        "--height", "48", "--width", "64", "--tokens", "16")


class Network(nn.Module):
    """The layers that the stand-ins of XMem and DEVA share."""

    def __init__(self, hidden):
        super().__init__()
        self.hidden_dim = hidden
        self.f4, self.f8, self.f16 = nn.Conv2d(3, 4, 4, stride=4), nn.Conv2d(4, 6, 2, stride=2), nn.Conv2d(6, 8, 2, stride=2)
        self.key, self.mask = nn.Conv2d(8, 9, 1), nn.Conv2d(5, 12, 16, stride=16)
        self.mix, self.out = nn.Conv2d(12 + hidden, hidden, 1), nn.Conv2d(hidden + 12, 1, 1)

    def features(self, frame):
        f4 = self.f4(frame)
        f8 = self.f8(f4)
        return self.f16(f8), f8, f4

    def keys(self, f16):
        both = self.key(f16)
        return both[:, :8], both[:, 8:].square() + 1, both[:, :8].sigmoid()

    def value(self, frame, f16, hidden, masks, others):
        count = masks.shape[1]
        inputs = torch.cat([frame[:, None].expand(-1, count, -1, -1, -1), masks[:, :, None], others[:, :, None]], 2)
        value = self.mask(inputs.flatten(0, 1)) + f16.mean()
        new = torch.tanh(self.mix(torch.cat([value, hidden.flatten(0, 1)], 1)))
        return value.view(1, count, *value.shape[1:]), new.view(1, count, *new.shape[1:])

    def probabilities(self, features, readout, hidden, last):
        count = readout.shape[1]
        new = torch.tanh(self.mix(torch.cat([readout, hidden], 2).flatten(0, 1)))
        logits = self.out(torch.cat([new, readout.flatten(0, 1)], 1)) + sum(f.mean() for f in features) + last
        things = F.interpolate(logits, scale_factor=16, mode="bilinear", align_corners=False).sigmoid()
        things = things.view(1, count, *things.shape[2:])
        rest = torch.prod(1 - things, 1, keepdim=True)
        return new.view(1, count, *new.shape[1:]), None, torch.cat([rest, things], 1).softmax(1)


def xmem(picture, out):
    class Model(Network):
        def __init__(self, config, checkpoint):
            super().__init__(64)

        def encode_key(self, frame):
            f16, f8, f4 = self.features(frame)
            return self.keys(f16) + (f16, f8, f4)

        def value_encoder(self, frame, f16, hidden, masks, others, deep):
            return self.value(frame, f16, hidden, masks, others)

        def encode_value(self, frame, f16, hidden, masks):
            count = masks.shape[1]
            others = [sum((masks[:, j] for j in range(count) if j != i), torch.zeros_like(masks[:, 0])) for i in range(count)]
            return self.value(frame, f16, hidden, masks, torch.stack(others, 1))

        def segment(self, features, readout, hidden, h_out, strip_bg):
            return self.probabilities(features, readout, hidden, 0)

    package("model.network", XMem=Model)
    run("export_xmem", "--checkpoint", "-", "--image", picture, "--out", out + "/xmem.pt")


def deva(picture, out):
    class Model(Network):
        def __init__(self, config):
            super().__init__(512)

        def load_weights(self, weights):
            pass

        def encode_image(self, frame):
            f16, f8, f4 = self.features(frame)
            return (f16, f8, f4), f16

        def transform_key(self, feature):
            return self.keys(feature)

        def encode_mask(self, frame, features, hidden, masks, is_deep_update):
            return self.value(frame, features[0], hidden, masks, masks)

        def segment(self, features, readout, hidden, last_masks, update_sensory):
            return self.probabilities(features, readout, hidden, last_masks.mean())

    package("deva.model.network", DEVA=Model)
    torch.save({}, out + "/empty.pth")
    run("export_xmem", "--deva", "--checkpoint", out + "/empty.pth", "--image", picture, "--out", out + "/deva.pt")


if __name__ == "__main__":
    sys.path.insert(0, sys.argv[1])
    out = sys.argv[2]
    names = sys.argv[3:] or ["lama", "ram", "sam", "sam2", "grounding_dino", "xmem", "deva"]
    import pliant_export

    pliant_export.picture = lambda file: (torch.rand(1, 3, 70, 90, generator=torch.Generator().manual_seed(3)) * 255).floor()
    for name in names:
        globals()[name]("photo.jpg", out)
