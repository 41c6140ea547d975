#include "acquisition/bus_tap.h"

#include <utility>

namespace annulus {

void BusTap::Record(RawRecord record) {
  if (opening_) {
    if (prelude_bytes_ + record.bytes.size() > kMaxPrelude) return;
    prelude_bytes_ += record.bytes.size();
    prelude_.push_back(std::move(record));
    return;
  }
  if (sink_ == nullptr || !status_) return;
  status_ = sink_->AppendRaw(std::move(record));
}

Status BusTap::Attach(ScanSink& sink) {
  sink_ = &sink;
  status_ = {};
  for (const RawRecord& record : prelude_) RETURN_IF_ERROR(sink.AppendRaw(record));
  return {};
}

}  // namespace annulus
