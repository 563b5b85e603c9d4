#pragma once

#include "app/commands/stage_options.h"
#include "app/fit/fit_stage.h"
#include "app/page/page_stage.h"
#include "app/predict/predict_stage.h"
#include "app/render/render_stage.h"
#include "app/seed/seed_stage.h"
#include "app/segment/extract_stage.h"
#include "app/segment/repair_stage.h"
#include "app/simulate/export_stage.h"
#include "app/simulate/simulate_stage.h"

namespace pliant {

/// The option tables of all stages, bound to stages that live as long as the program.
inline const std::vector<OptionTable>& all_tables() {
  static ReconstructStage reconstruct;
  static SegmentStage segment;
  static ExtractStage extract;
  static RepairStage repair;
  static SeedStage seed;
  static PredictStage predict;
  static FitStage fit;
  static SimulateStage simulate;
  static RenderStage render;
  static ExportStage exported;
  static PageStage page;
  static const std::vector<OptionTable> tables = {options_of(reconstruct), options_of(segment),  options_of(extract),
                                                  options_of(repair),      options_of(seed),     options_of(predict),
                                                  options_of(fit),         options_of(simulate), options_of(render),
                                                  options_of(exported),    options_of(page)};
  return tables;
}

}  // namespace pliant
