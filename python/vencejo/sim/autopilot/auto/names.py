"""MAV_CMD numbers of missions, and ArduPlane's names of them, as in "Mission: 2 WP"."""

from __future__ import annotations

from enum import IntEnum

__all__ = ["AT_ONCE", "Cmd", "is_nav", "word"]


class Cmd(IntEnum):
    """Commands that a mission may hold."""

    NAV_WAYPOINT = 16
    NAV_LOITER_UNLIM = 17
    NAV_LOITER_TURNS = 18
    NAV_LOITER_TIME = 19
    NAV_RETURN_TO_LAUNCH = 20
    NAV_LAND = 21
    NAV_TAKEOFF = 22
    NAV_CONTINUE_AND_CHANGE_ALT = 30
    NAV_LOITER_TO_ALT = 31
    NAV_ARC_WAYPOINT = 36
    NAV_ALTITUDE_WAIT = 83
    NAV_VTOL_TAKEOFF = 84
    NAV_VTOL_LAND = 85
    NAV_GUIDED_ENABLE = 92
    NAV_DELAY = 93
    NAV_PAYLOAD_PLACE = 94
    NAV_LAST = 95
    CONDITION_DELAY = 112
    CONDITION_DISTANCE = 114
    CONDITION_YAW = 115
    DO_JUMP = 177
    DO_CHANGE_SPEED = 178
    DO_SET_HOME = 179
    DO_SET_RELAY = 181
    DO_REPEAT_RELAY = 182
    DO_SET_SERVO = 183
    DO_REPEAT_SERVO = 184
    DO_RETURN_PATH_START = 188
    DO_LAND_START = 189
    DO_GO_AROUND = 191
    DO_PAUSE_CONTINUE = 193
    DO_SET_REVERSE = 194
    DO_SET_ROI_LOCATION = 195
    DO_SET_ROI_NONE = 197
    DO_SET_ROI = 201
    DO_DIGICAM_CONFIGURE = 202
    DO_DIGICAM_CONTROL = 203
    DO_MOUNT_CONTROL = 205
    DO_SET_CAM_TRIGG_DIST = 206
    DO_FENCE_ENABLE = 207
    DO_PARACHUTE = 208
    DO_INVERTED_FLIGHT = 210
    DO_GRIPPER = 211
    DO_AUTOTUNE_ENABLE = 212
    NAV_SET_YAW_SPEED = 213
    DO_SET_RESUME_REPEAT_DIST = 215
    DO_SPRAYER = 216
    DO_SEND_SCRIPT_MESSAGE = 217
    DO_AUX_FUNCTION = 218
    DO_GUIDED_LIMITS = 222
    DO_ENGINE_CONTROL = 223
    SET_CAMERA_ZOOM = 531
    SET_CAMERA_FOCUS = 532
    SET_CAMERA_SOURCE = 534
    JUMP_TAG = 600
    DO_JUMP_TAG = 601
    DO_GIMBAL_MANAGER_PITCHYAW = 1000
    IMAGE_START_CAPTURE = 2000
    IMAGE_STOP_CAPTURE = 2001
    VIDEO_START_CAPTURE = 2500
    VIDEO_STOP_CAPTURE = 2501
    DO_VTOL_TRANSITION = 3000
    NAV_SCRIPT_TIME = 42702


_WORDS = {
    Cmd.NAV_WAYPOINT: "WP",
    Cmd.NAV_LOITER_UNLIM: "LoitUnlim",
    Cmd.NAV_LOITER_TURNS: "LoitTurns",
    Cmd.NAV_LOITER_TIME: "LoitTime",
    Cmd.NAV_RETURN_TO_LAUNCH: "RTL",
    Cmd.NAV_LAND: "Land",
    Cmd.NAV_TAKEOFF: "Takeoff",
    Cmd.NAV_CONTINUE_AND_CHANGE_ALT: "ContinueAndChangeAlt",
    Cmd.NAV_LOITER_TO_ALT: "LoitAltitude",
    Cmd.NAV_ARC_WAYPOINT: "ArcWP",
    Cmd.NAV_ALTITUDE_WAIT: "AltitudeWait",
    Cmd.NAV_VTOL_TAKEOFF: "VTOLTakeoff",
    Cmd.NAV_VTOL_LAND: "VTOLLand",
    Cmd.NAV_GUIDED_ENABLE: "GuidedEnable",
    Cmd.NAV_DELAY: "Delay",
    Cmd.NAV_PAYLOAD_PLACE: "PayloadPlace",
    Cmd.CONDITION_DELAY: "CondDelay",
    Cmd.CONDITION_DISTANCE: "CondDist",
    Cmd.CONDITION_YAW: "CondYaw",
    Cmd.DO_JUMP: "Jump",
    Cmd.DO_CHANGE_SPEED: "ChangeSpeed",
    Cmd.DO_SET_HOME: "SetHome",
    Cmd.DO_SET_RELAY: "SetRelay",
    Cmd.DO_REPEAT_RELAY: "RepeatRelay",
    Cmd.DO_SET_SERVO: "SetServo",
    Cmd.DO_REPEAT_SERVO: "RepeatServo",
    Cmd.DO_RETURN_PATH_START: "ReturnPathStart",
    Cmd.DO_LAND_START: "LandStart",
    Cmd.DO_GO_AROUND: "Go Around",
    Cmd.DO_PAUSE_CONTINUE: "PauseContinue",
    Cmd.DO_SET_REVERSE: "SetReverse",
    Cmd.DO_SET_ROI_LOCATION: "SetROILocation",
    Cmd.DO_SET_ROI_NONE: "SetROINone",
    Cmd.DO_SET_ROI: "SetROI",
    Cmd.DO_DIGICAM_CONFIGURE: "DigiCamCfg",
    Cmd.DO_DIGICAM_CONTROL: "DigiCamCtrl",
    Cmd.DO_MOUNT_CONTROL: "MountControl",
    Cmd.DO_SET_CAM_TRIGG_DIST: "SetCamTrigDst",
    Cmd.DO_FENCE_ENABLE: "FenceEnable",
    Cmd.DO_PARACHUTE: "Parachute",
    Cmd.DO_INVERTED_FLIGHT: "InvertedFlight",
    Cmd.DO_GRIPPER: "Gripper",
    Cmd.DO_AUTOTUNE_ENABLE: "AutoTuneEnable",
    Cmd.NAV_SET_YAW_SPEED: "SetYawSpd",
    Cmd.DO_SET_RESUME_REPEAT_DIST: "SetRepeatDist",
    Cmd.DO_SPRAYER: "Sprayer",
    Cmd.DO_SEND_SCRIPT_MESSAGE: "Scripting",
    Cmd.DO_AUX_FUNCTION: "AuxFunction",
    Cmd.DO_GUIDED_LIMITS: "GuidedLimits",
    Cmd.DO_ENGINE_CONTROL: "EngineControl",
    Cmd.SET_CAMERA_ZOOM: "SetCameraZoom",
    Cmd.SET_CAMERA_FOCUS: "SetCameraFocus",
    Cmd.SET_CAMERA_SOURCE: "SetCameraSource",
    Cmd.JUMP_TAG: "Tag",
    Cmd.DO_JUMP_TAG: "JumpToTag",
    Cmd.DO_GIMBAL_MANAGER_PITCHYAW: "GimbalPitchYaw",
    Cmd.IMAGE_START_CAPTURE: "ImageStartCapture",
    Cmd.IMAGE_STOP_CAPTURE: "ImageStopCapture",
    Cmd.VIDEO_START_CAPTURE: "VideoStartCapture",
    Cmd.VIDEO_STOP_CAPTURE: "VideoStopCapture",
    Cmd.DO_VTOL_TRANSITION: "VTOLTransition",
    Cmd.NAV_SCRIPT_TIME: "NavScriptTime",
}

AT_ONCE = frozenset(
    {
        Cmd.DO_GRIPPER,
        Cmd.DO_SET_SERVO,
        Cmd.DO_SET_RELAY,
        Cmd.DO_REPEAT_SERVO,
        Cmd.DO_REPEAT_RELAY,
        Cmd.DO_DIGICAM_CONFIGURE,
        Cmd.DO_DIGICAM_CONTROL,
        Cmd.DO_SET_CAM_TRIGG_DIST,
        Cmd.DO_PARACHUTE,
        Cmd.DO_SEND_SCRIPT_MESSAGE,
        Cmd.DO_SPRAYER,
        Cmd.DO_AUX_FUNCTION,
        Cmd.DO_SET_RESUME_REPEAT_DIST,
        Cmd.DO_GIMBAL_MANAGER_PITCHYAW,
        Cmd.JUMP_TAG,
        Cmd.IMAGE_START_CAPTURE,
        Cmd.IMAGE_STOP_CAPTURE,
        Cmd.SET_CAMERA_ZOOM,
        Cmd.SET_CAMERA_FOCUS,
        Cmd.SET_CAMERA_SOURCE,
        Cmd.VIDEO_START_CAPTURE,
        Cmd.VIDEO_STOP_CAPTURE,
    }
)
"""Payload commands: complete as soon as they start, without MISSION_ITEM_REACHED."""


def is_nav(command: int) -> bool:
    """True for a navigation command: it moves the plane and holds the mission until it is complete."""
    return command <= Cmd.NAV_LAST or command in (Cmd.NAV_SET_YAW_SPEED, Cmd.NAV_SCRIPT_TIME, 42703)


def word(command: int) -> str:
    """ArduPlane's name of a command."""
    try:
        return _WORDS[Cmd(command)]
    except (ValueError, KeyError):
        return "?"
