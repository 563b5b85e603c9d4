#include "app/page/clip_html.h"

#include "app/page/page_assets.h"
#include "app/report/html.h"
#include "gaussians/base/error.h"
#include "gaussians/io/files/base64.h"
#include "gaussians/io/files/files.h"

namespace pliant {
PageSizes write_page(const std::filesystem::path& file, const ClipPage& page, SectionPacker& packer, size_t most) {
  std::string html(page_template());
  // Before the user's text, which may contain such a mark.
  fill_mark(html, "/*STYLE*/", std::string(page_style()));
  fill_mark(html, "/*SCRIPT*/", in_script(std::string(page_script())));
  fill_mark(html, "<!--TITLE-->", html_escaped(page.file.header["title"]));
  fill_mark(html, "<!--POSTER-->", "data:image/webp;base64," + base64(page.poster));
  fill_mark(html, "<!--HEADER-->",
            "<script type=\"application/json\" id=\"clip-header\">" + json_in_script(page.file.header) + "</script>");
  PageSizes sizes;
  sizes.until_poster = html.find("<canvas");
  const std::string mark = "<!--SECTIONS-->";
  sizes.until_motion = html.find(mark);
  std::string sections;
  const auto add = [&](const std::string& name, const std::string& text) {
    sections += "<script type=\"application/octet-stream\" id=\"clip-" + name + "\">" + text + "</script>\n";
    sizes.sections[name] = text.size();
  };
  packer.pack(page.file);
  for (const char* name : {"object", "motion", "background", "levels", "solver"}) {
    if (page.file.sections.count(name) == 0) continue;
    add(name, packer.packed(name));
    if (std::string(name) == "motion") sizes.until_motion += sections.size();
  }
  if (!page.video.empty()) add("video", base64(page.video));
  fill_mark(html, mark, sections);
  sizes.all = html.size();
  CHECK_MSG(sizes.all <= most, "size of a page");
  write_text(file, html);
  return sizes;
}

}  // namespace pliant
