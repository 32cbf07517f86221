"""More observers than one machine serves: the robot publishes into rooms of a media server.

The queue, driving and Stop stay with the robot; the media server carries picture, sound and news of
the robot's room to those who only watch. It is LiveKit, or any other by WHIP.
"""
