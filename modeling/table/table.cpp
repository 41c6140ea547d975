#include "modeling/table/table.h"

#include "modeling/table/measurement_groups.h"
#include "modeling/table/measurement_list.h"

namespace annulus {

Result<MeasurementTable> MeasureTable(const MeasuredSurface& body, Landmarks landmarks) {
  if (landmarks.found.empty()) {
    return Fail("measure the body", "no landmark or level of it was found",
                "scan again with the whole body or head in the ring");
  }
  MeasurementList list(body, std::move(landmarks));
  AddLevels(list);
  AddHeights(list);
  AddLines(list);
  AddHead(list);
  AddSegments(list);
  return list.Finish();
}

}  // namespace annulus
