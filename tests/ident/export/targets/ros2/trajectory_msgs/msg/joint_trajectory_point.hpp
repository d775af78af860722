// Stands in for ROS 2's header.
#pragma once
#include <vector>
namespace trajectory_msgs::msg {
struct JointTrajectoryPoint {
  std::vector<double> positions, velocities, accelerations;
};
}  // namespace trajectory_msgs::msg
