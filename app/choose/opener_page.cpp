#include "app/choose/opener.h"
#include "gaussians/base/embed.h"

// PLIANT_OPEN_PAGE is the path of the file.
PLIANT_EMBED(pliant_open_page, PLIANT_OPEN_PAGE);

namespace pliant {

LocalServer::Page open_page() {
  return styled_page(
      std::string(pliant_open_page_begin, static_cast<size_t>(pliant_open_page_end - pliant_open_page_begin)));
}

}  // namespace pliant
