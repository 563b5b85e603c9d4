#include "app/suite/suite.h"
#include "gaussians/base/embed.h"

// PLIANT_WORKFLOW is the path of the workflow.
PLIANT_EMBED(pliant_suite_workflow, PLIANT_WORKFLOW);

namespace pliant {

std::string_view suite_workflow() {
  return {pliant_suite_workflow_begin, static_cast<size_t>(pliant_suite_workflow_end - pliant_suite_workflow_begin)};
}

}  // namespace pliant
