#include "app/pipeline/stages.h"
#include "gaussians/base/error.h"
#include "physics/body/make_particles.h"

namespace pliant {

MaterialValues check_material(const Scene& scene, const MaterialValues& command_line) {
  const MaterialValues& file = scene.settings.material;
  MaterialValues values;
  values.young = command_line.young ? command_line.young : file.young;
  values.poisson = command_line.poisson ? command_line.poisson : file.poisson;
  values.density = command_line.density ? command_line.density : file.density;
  std::string missing;
  if (!values.young) missing += " --young";
  if (!values.poisson) missing += " --poisson";
  if (!values.density) missing += " --density";
  if (!missing.empty())
    throw usage_error("material", missing.substr(1), "is not known for this scene",
                      "give --young E[Pa] --poisson NU --density RHO[kg/m^3], or \"material\" in scene.json");
  validate_material("material", *values.young, *values.poisson, *values.density);
  return values;
}

}  // namespace pliant
