#include "station/console/console_frame.h"

#include "station/console/job_routes.h"
#include "station/console/recording_routes.h"

namespace annulus {

void AddAllRoutes(RouteTable& table, ConsoleContext& context, ConsoleFrame& frame) {
  AddSessionRoutes(table, context, frame);
  AddAdminRoutes(table, context, frame);
  for (const auto& add :
       {AddCustomerRoutes, AddBoothRoutes, AddJobRoutes, AddScanRoutes, AddMeasureRoutes, AddGlassesRoutes,
        AddReshapeRoutes, AddTechnicianRoutes, AddRecordingRoutes, AddCalibrationRoutes, AddReplayRoutes}) {
    add(table, context);
  }
}

}  // namespace annulus
