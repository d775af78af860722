// Stands in for ROS 2's header: without threads.
#pragma once
namespace realtime_tools {
template <typename Value>
class RealtimeBuffer {
 public:
  void writeFromNonRT(const Value &value) { value_ = value; }
  Value *readFromRT() { return &value_; }

 private:
  Value value_{};
};
}  // namespace realtime_tools
