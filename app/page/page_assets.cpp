#include "app/page/page_assets.h"

#include "gaussians/base/embed.h"

// PLIANT_PAGE_* are the paths of the files.
PLIANT_EMBED(pliant_page_template, PLIANT_PAGE_TEMPLATE);
PLIANT_EMBED(pliant_page_style, PLIANT_PAGE_STYLE);
PLIANT_EMBED(pliant_page_script, PLIANT_PAGE_SCRIPT);
#ifdef PLIANT_PAGE_SOLVER
PLIANT_EMBED(pliant_page_solver, PLIANT_PAGE_SOLVER);
#endif

namespace pliant {

std::string_view page_template() {
  return {pliant_page_template_begin, static_cast<size_t>(pliant_page_template_end - pliant_page_template_begin)};
}
std::string_view page_style() {
  return {pliant_page_style_begin, static_cast<size_t>(pliant_page_style_end - pliant_page_style_begin)};
}
std::string_view page_script() {
  return {pliant_page_script_begin, static_cast<size_t>(pliant_page_script_end - pliant_page_script_begin)};
}

std::string_view solver_module() {
#ifdef PLIANT_PAGE_SOLVER
  return {pliant_page_solver_begin, static_cast<size_t>(pliant_page_solver_end - pliant_page_solver_begin)};
#else
  return {};
#endif
}

}  // namespace pliant
