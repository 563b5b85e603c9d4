#include "app/segment/associated_masks.h"

#include "app/segment/interruption.h"
#include "app/segment/label_choice.h"
#include "segmentation/associate/associate.h"
#include "segmentation/associate/gaga.h"
#include "segmentation/labelling/label_set.h"

namespace pliant {

AssociatedMasks associated_masks(const Context& context, const Scene& scene, const SegmentStage& stage,
                                 const SemanticOptions& semantic, const std::filesystem::path& folder) {
  // Names that lie beside the masks may be those of things in single photos, as `label` writes them.
  const bool labelled = std::filesystem::exists(folder / "labels.json");
  MaskSet masks = load_masks(folder, labels_of(folder, scene.settings.labels), scene.cameras);
  if (!stage.mask_zero.empty()) label_background(masks);
  if (stage.associate == "never" || stage.label.track) return {masks};
  const MaskSet as_labelled = masks;
  const uint32_t rest = labelled ? take_out_rest(masks) : 0;
  const auto under_way = [&] { stop_if_interrupted(context, "segment"); };
  MaskSet associated;
  bool ids_hold = false;
  if (stage.associate == "gaga") {
    GagaResult result = associate_by_centres({.held_out = semantic.held_out, .under_way = under_way}, scene.cloud,
                                             scene.cameras, masks);
    context.progress.say("segment: association: " + result.summary.describe());
    associated = std::move(result.masks);
  } else {
    AssociateOptions options;
    options.held_out = semantic.held_out;
    options.under_way = under_way;
    options.footprint.render = semantic.render;
    // What `label` has just made holds in single photos, whatever of it agrees.
    if (stage.associate == "auto" && !labels_photos(stage)) options.keep_above = 0.75;
    AssociateResult result = associate(options, scene.cloud, scene.cameras, masks);
    if (!result.summary.associated) return {as_labelled};
    context.progress.say("segment: association: " + result.summary.describe());
    associated = std::move(result.masks);
    ids_hold = result.summary.reused_ids == 0;
  }
  if (labelled) associated.names = carried_names(masks, associated);
  if (rest != 0) put_back_rest(as_labelled, rest, associated);
  return {std::move(associated), ids_hold};
}

}  // namespace pliant
