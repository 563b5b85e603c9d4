#pragma once

#include <vector>

#include "app/run/run_directory.h"
#include "app/segment/segment_stage.h"
#include "segmentation/sheets/objects_sheet.h"

namespace pliant {

/// Writes objects_sheet.json beside objects.png: which camera and part of its picture every part of the sheet shows.
void write_sheet_cells(const RunDirectory& run, const std::vector<SheetCell>& cells,
                       const std::vector<Camera>& cameras);

/// Writes selection_sheet.json beside selection.png: the cameras whose pictures it shows, and where.
void write_selection_cells(const RunDirectory& run, const std::vector<Camera>& sides);

/// `cameras` of the scene, and those sides of selection.png on which a gesture of `stage` was made.
std::vector<Camera> with_sides(const SegmentStage& stage, const std::vector<Camera>& sides,
                               std::vector<Camera> cameras);
/// The cells of selection.png that show the sides.
nlohmann::json sides_json(const std::vector<Camera>& sides);

struct SheetPrompts {
  SegmentStage stage;         ///< without gestures on sheets
  std::vector<Camera> sides;  ///< of selection.png, when gestures count on them; the scene does not have these
};

/// Boxes, clicks and strokes whose camera is "sheet" count pixels of objects.png of the run directory, those whose
/// camera is "selection" pixels of selection.png; they become those of the camera that is shown there.  run.json keeps
/// what they became in the result that is there, so that the command can be repeated and added to although the pictures
/// are others by then. Throws Error{kUsage} when there is no sheet or it shows no picture there.
SheetPrompts with_sheet_prompts(const Context& context, RunDirectory& run, const SegmentStage& stage);

}  // namespace pliant
