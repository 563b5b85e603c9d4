#include "app/evaluate/study/study_assets.h"

#include "gaussians/base/embed.h"

// PLIANT_STUDY_* are the paths of the files.
PLIANT_EMBED(pliant_study_template, PLIANT_STUDY_TEMPLATE);
PLIANT_EMBED(pliant_study_style, PLIANT_STUDY_STYLE);
PLIANT_EMBED(pliant_study_script, PLIANT_STUDY_SCRIPT);

namespace pliant {

std::string_view study_template() {
  return {pliant_study_template_begin, static_cast<size_t>(pliant_study_template_end - pliant_study_template_begin)};
}
std::string_view study_style() {
  return {pliant_study_style_begin, static_cast<size_t>(pliant_study_style_end - pliant_study_style_begin)};
}
std::string_view study_script() {
  return {pliant_study_script_begin, static_cast<size_t>(pliant_study_script_end - pliant_study_script_begin)};
}

}  // namespace pliant
