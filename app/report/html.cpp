#include "app/report/html.h"

#include <fmt/format.h>

#include "gaussians/base/error.h"
#include "gaussians/io/files/base64.h"
#include "gaussians/io/files/files.h"

namespace pliant {
namespace fs = std::filesystem;

std::string html_begin(const std::string& title) {
  return fmt::format(
             "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
             "content=\"width=device-width,initial-scale=1\"><title>{}</title><style>",
             html_escaped(title)) +
         "body{font:16px/1.5 system-ui,sans-serif;max-width:60rem;margin:2rem auto;padding:0 1rem;color:#222}"
         "img,video{max-width:100%;border:1px solid #ccc}figure{margin:1rem 0}figcaption{color:#555}"
         "table{display:block;overflow-x:auto;border-collapse:collapse}td,th{border:1px solid #ccc;padding:.2rem "
         ".6rem;text-align:left;vertical-align:top}"
         "pre{overflow-x:auto}code{font-size:.85em;word-break:break-all}</style></head><body>\n";
}

std::string html_escaped(const std::string& text) {
  std::string out;
  for (char c : text) {
    if (c == '<')
      out += "&lt;";
    else if (c == '>')
      out += "&gt;";
    else if (c == '&')
      out += "&amp;";
    else if (c == '"')
      out += "&quot;";
    else
      out += c;
  }
  return out;
}

std::string html_picture(const RunDirectory& run, const std::string& file, const std::string& caption) {
  if (!fs::exists(run / file)) return "";
  return fmt::format("<figure><img src=\"data:image/png;base64,{}\" alt=\"{}\"><figcaption>{}</figcaption></figure>\n",
                     base64(read_text(run / file)), html_escaped(caption), html_escaped(caption));
}

std::string html_video(const RunDirectory& run, const std::string& file, const std::string& caption) {
  if (!fs::exists(run / file)) return "";
  return fmt::format(
      "<figure><video src=\"data:video/mp4;base64,{}\" controls loop muted autoplay playsinline></video>"
      "<figcaption>{}</figcaption></figure>\n",
      base64(read_text(run / file)), html_escaped(caption));
}

void fill_mark(std::string& page, const std::string& mark, const std::string& text) {
  const size_t place = page.find(mark);
  CHECK_MSG(place != std::string::npos, "mark of the page's template");
  page.replace(place, mark.size(), text);
}

std::string in_script(std::string text) {
  for (size_t k = 0; (k = text.find("</", k)) != std::string::npos; k += 2) text.replace(k, 2, "<\\/");
  return text;
}

std::string json_in_script(const nlohmann::json& value) {
  std::string out;
  for (const char c : value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

}  // namespace pliant
