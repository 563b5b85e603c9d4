#pragma once

#include <vector>

#include "app/pipeline/run_directory.h"
#include "app/pipeline/stages.h"
#include "segmentation/lift/objects_sheet.h"

namespace pliant {

/// Writes objects_sheet.json beside objects.png: which camera and part of its picture every part of the sheet shows.
void write_sheet_cells(const RunDirectory& run, const std::vector<SheetCell>& cells, const std::vector<Camera>& cameras);

/// Boxes, clicks and strokes whose camera is "sheet" count pixels of objects.png of the run directory; they become those of
/// the camera that is shown there.  run.json keeps what they became, so that the command can be repeated although objects.png
/// is another one by then.  Throws Error{kUsage} when there is no sheet or it shows no picture there.
SegmentStage with_sheet_prompts(const Context& context, RunDirectory& run, SegmentStage stage);

}  // namespace pliant
