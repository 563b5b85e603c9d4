#pragma once

#include "app/live/local_server.h"
#include "app/run/options.h"
#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// `pliant view`: the page of a simulated run, with the solver of this program behind it.
struct ViewOptions {
  LocalServerOptions server;
  bool browser = true;  ///< open it in the default browser
};
OptionTable options_of(ViewOptions& options);

/// The page that a browser is sent: `clip_html` with a policy that lets it connect to the server it came from.
LocalServer::Page live_page(std::string clip_html);

/// Serves until it is interrupted.  Recordings go to the folder `recordings` of the
/// run directory.  Throws Error{kUsage} where the object cannot be played with or the address not be used.
nlohmann::json run_view(const Context& context, const RunDirectory& run, const Scene& scene,
                        const ViewOptions& options);

}  // namespace pliant
