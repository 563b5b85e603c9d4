// What becomes of the object that is chosen.

#include <omp.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/choose/chooser.h"
#include "app/live/live_view.h"
#include "app/run/attach_scene.h"

namespace pliant {
namespace {

constexpr double kSimulated = 0.1;  // s, of the motion that the page begins with

/// A fit is of the particles and the scale that it was made with; no request can ask to ignore another one.
void leave_out_foreign_fit(const Context& context, const RunDirectory& run, const Scene& scene,
                           SimulateStage& simulate) {
  const std::string of = fit_is_of(run, scene);
  if (of.empty() && !is_refit_unfinished(run)) return;
  simulate.use_fit = false;
  context.progress.say("simulate: the existing fit is not used: " +
                       (of.empty() ? "one that is to replace it is unfinished" : "it was made with " + of));
}

}  // namespace

void Chooser::make(const Context& context, const ChooseRequest& request) {
  Scene scene = scene_;  // which the object may scale
  ObjectStages stages = stages_;
  stages.extract.object = std::to_string(request.object == 0 ? SelectionShape::kObject : request.object);
  stages.predict.label = request.label;
  SimulateStage simulate;
  simulate.duration = kSimulated;
  simulate.expects_push = false;
  prepare_object(context, run_, scene, stages, simulate);
  leave_out_foreign_fit(context, run_, scene, simulate);
  run_simulate(context, run_, scene, simulate);
  const LiveScreen screen = live_screen(context, run_, scene, context_.progress);
  site_.show(screen);
  tell({{"reload", true}});
  repair(context, scene, screen);
}

void Chooser::repair(const Context& context, const Scene& scene, LiveScreen screen) {
  // The hole closes behind the object while it is being moved; the page has it when it is loaded again.
  omp_set_num_threads(std::max(1, omp_get_max_threads() / 2));
  try {
    run_repair(context, run_, scene, {});
    site_.show(live_screen(context, run_, scene, context_.progress));
    site_.tell(text_of({{"said", "The hole behind the object has been repaired. Reload the page to see it."}}));
  } catch (const std::exception& error) {
    if (context.interrupted()) throw;
    const std::string problem = std::string("The hole behind the object could not be repaired: ") + error.what();
    context_.progress.warn("view: " + problem);
    const std::string said = text_of({{"said", problem}});
    site_.tell(said);
    screen.connect = [connect = screen.connect, said](std::shared_ptr<Connection> connection) {
      connection->send_text(said);
      return connect(std::move(connection));
    };
    site_.show(std::move(screen));
  }
}

}  // namespace pliant
