"""The types of messages of which a picture can be made (:mod:`mapper.io.contents.pictures`)."""

PICTURED = frozenset({"sensor_msgs/Image", "sensor_msgs/CompressedImage", "sensor_msgs/PointCloud2"})
