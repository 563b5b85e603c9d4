#pragma once

#include "app/live/live_site.h"
#include "app/run/options.h"
#include "app/run/run_directory.h"
#include "gaussians/io/scene/scene.h"

namespace pliant {

/// `pliant view`: a scene in the browser, with this program behind it.
struct ViewOptions {
  LocalServerOptions server;
  bool browser = true;  ///< open it in the default browser
  bool choose = false;  ///< begin with the choice of an object, although one is simulated
};
OptionTable options_of(ViewOptions& options);

/// The page that a browser is sent: `clip_html` with a policy that lets it connect to the server it came from.
LocalServer::Page live_page(std::string clip_html);

/// The object of a simulated run, to be moved.  Recordings go to the folder `recordings` of the run directory; once
/// `console`, which must outlive the clients, is told that they cannot be kept.  Throws Error{kUsage} where the object
/// cannot be played with.
LiveScreen live_screen(const Context& context, const RunDirectory& run, const Scene& scene, Progress& console);

/// Serves what the site shows, by a server with its handler, until it is interrupted.
nlohmann::json serve(const Context& context, const ViewOptions& options, LocalServer& server, LiveSite& site);

}  // namespace pliant
