#include "app/page/clip_html.h"

#include "app/page/page_assets.h"
#include "app/report/html.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/base64.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace {

void fill(std::string& page, const std::string& mark, const std::string& text) {
  const size_t place = page.find(mark);
  CHECK_MSG(place != std::string::npos, "mark of the page's template");
  page.replace(place, mark.size(), text);
}

/// Text of a script element, in which nothing may look like its end.
std::string in_script(std::string text) {
  for (size_t k = 0; (k = text.find("</", k)) != std::string::npos; k += 2) text.replace(k, 2, "<\\/");
  return text;
}

}  // namespace

PageSizes write_page(const std::filesystem::path& file, const ClipPage& page) {
  std::string html(page_template());
  fill(html, "/*STYLE*/", std::string(page_style()));
  fill(html, "<!--TITLE-->", html_escaped(page.file.header["title"]));
  fill(html, "<!--POSTER-->", "data:image/webp;base64," + base64(page.poster));
  fill(html, "<!--HEADER-->",
       "<script type=\"application/json\" id=\"clip-header\">" + in_script(page.file.header.dump()) + "</script>");
  PageSizes sizes;
  sizes.until_poster = html.find("<canvas");
  fill(html, "/*SCRIPT*/", in_script(std::string(page_script())));
  const std::string mark = "<!--SECTIONS-->";
  sizes.until_motion = html.find(mark);
  std::string sections;
  const auto add = [&](const std::string& name, const std::string& text) {
    sections += "<script type=\"application/octet-stream\" id=\"clip-" + name + "\">" + text + "</script>\n";
    sizes.sections[name] = text.size();
  };
  for (const char* name : {"object", "motion", "background", "levels", "solver"}) {
    const auto section = page.file.sections.find(name);
    if (section == page.file.sections.end()) continue;
    add(name, packed_section(section->second));
    if (std::string(name) == "motion") sizes.until_motion += sections.size();
  }
  if (!page.video.empty()) add("video", base64(page.video));
  fill(html, mark, sections);
  sizes.all = html.size();
  write_text(file, html);
  return sizes;
}

}  // namespace pliant
