#include "app/choose/choose_assets.h"

#include "gaussians/base/embed.h"

// PLIANT_CHOOSE_* and PLIANT_PAGES_STYLE are the paths of the files.
PLIANT_EMBED(pliant_choose_template, PLIANT_CHOOSE_TEMPLATE);
PLIANT_EMBED(pliant_choose_style, PLIANT_CHOOSE_STYLE);
PLIANT_EMBED(pliant_choose_script, PLIANT_CHOOSE_SCRIPT);
PLIANT_EMBED(pliant_pages_style, PLIANT_PAGES_STYLE);

namespace pliant {

std::string_view choose_template() {
  return {pliant_choose_template_begin, static_cast<size_t>(pliant_choose_template_end - pliant_choose_template_begin)};
}
std::string_view choose_style() {
  return {pliant_choose_style_begin, static_cast<size_t>(pliant_choose_style_end - pliant_choose_style_begin)};
}
std::string_view choose_script() {
  return {pliant_choose_script_begin, static_cast<size_t>(pliant_choose_script_end - pliant_choose_script_begin)};
}
std::string_view pages_style() {
  return {pliant_pages_style_begin, static_cast<size_t>(pliant_pages_style_end - pliant_pages_style_begin)};
}

}  // namespace pliant
