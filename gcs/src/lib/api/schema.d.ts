// Generated from schemas/openapi.json by `npm run api`. Do not edit.

export interface paths {
    "/api/v1/cameras": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the cameras by name. */
        get: operations["list_cameras"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/cameras/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** A camera. */
        get: operations["get_camera"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/cameras/{name}/recording": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Starts recording the camera to a file on the machine to which it is connected. Sends nothing to the vehicle. */
        post: operations["start_recording"];
        /** Stops the recording. */
        delete: operations["stop_recording"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/cameras/{name}/snapshot": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Takes a still image: the newest one, with time, position, altitudes and attitude of the vehicle, where known, in its
         *     EXIF and XMP data.
         */
        get: operations["snapshot"];
        put?: never;
        /** Takes a still image as GET does, and also stores it beside the recordings. */
        post: operations["keep_snapshot"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/cameras/{name}/stream": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * The camera's images, on a WebSocket of their own. Text messages are `CameraMessage`. Binary messages are images: a
         *     header of 20 bytes, all numbers little-endian, then the encoded image. Header: version (u8, is 1); codec (u8: 1
         *     H.264 byte stream, one access unit, key frames with their parameter sets; 2 JPEG); flags (u8: bit 0 key frame); 0
         *     (u8); width, height (u16 each); time of capture (u64, microseconds since 1970); number of the image (u32). A slow
         *     viewer misses images and continues at a key frame.
         */
        get: operations["watch"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/commands": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the commands that a plan may contain. */
        get: operations["list_commands"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/control/keep": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Declines the request of another operator for the control that this session holds. One that requests it by acting does
         *     not request it again for five minutes, while this session holds control.
         */
        post: operations["keep_control"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/control/release": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Releases control: to the session that requests it, if any. Also withdraws a request of this session. */
        post: operations["release_control"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/control/request": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Requests control from the session that holds it; takes it when none does. */
        post: operations["request_control"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/control/take": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Takes control, if no other session holds it. */
        post: operations["take_control"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/draft": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the draft of the plan that operators edit, and conflicting drafts. */
        get: operations["get_draft"];
        /**
         * Saves the draft as a change of revision `base`. If another author has changed it since, the request is refused, and
         *     the draft is kept as a conflicting one.
         */
        put: operations["put_draft"];
        post?: never;
        /** Deletes the draft and conflicting drafts. */
        delete: operations["delete_draft"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/elevation": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Ground elevation at a position; null when unknown. The list of map sources shows which of them fail. */
        get: operations["get_elevation"];
        put?: never;
        /** Ground elevations at up to 2000 positions. */
        post: operations["get_elevations"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/elevation/profile": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Terrain profile along a line, or along a plan's legs from its home. */
        post: operations["get_elevation_profile"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/footage": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists camera recordings and images on the server's disk, newest first, at most 1000. */
        get: operations["list_footage"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/footage/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns a recording (Matroska) or image (JPEG), or the requested range of it, so that a player can seek. A file that
         *     is still being recorded ends where it ended when the request arrived.
         */
        get: operations["get_footage"];
        put?: never;
        post?: never;
        /** Deletes a recording or image from the server's disk. A file that is being recorded is not deleted. */
        delete: operations["delete_footage"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/heartbeat": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Starts or stops the station's heartbeat, on which the vehicles' ground-station failsafe depends. On board a vehicle, it
         *     is sent while an operator's page or program has its WebSocket open, and 5 s longer.
         */
        put: operations["set_heartbeat"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/history": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the stored history of each aircraft of each fleet, remote or on board: its files, and their gaps. */
        get: operations["list_history"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/history/{place}/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns a history file (MCAP), or the requested range of it. A file that is still being written ends where it ended
         *     when the request arrived.
         */
        get: operations["get_history_file"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/info": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the server's version, and whether it requires a token. Needs no session. */
        get: operations["info"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/links": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the links with their traffic counters. */
        get: operations["list_links"];
        put?: never;
        /** Opens another link. It connects, and reconnects, by itself. */
        post: operations["open_link"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/links/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /** Closes a link. */
        delete: operations["close_link"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/areas": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the offline areas of all sources, oldest first. */
        get: operations["list_map_areas"];
        put?: never;
        /** Creates an offline area and starts its download. Refused when the source's terms of use forbid it. */
        post: operations["add_map_area"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/areas/estimate": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Estimates an area: number of tiles, and bytes still to be downloaded. */
        post: operations["estimate_map_area"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/areas/import": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Imports an exported MBTiles file, of this or another station, into a source's cache, as a completed area. */
        post: operations["import_map_area"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/areas/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns an offline area. */
        get: operations["get_map_area"];
        put?: never;
        post?: never;
        /** Removes an offline area. Its tiles stay in the cache until they are evicted as least recently used. */
        delete: operations["remove_map_area"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/areas/{id}/export": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Exports the downloaded part of an area as an MBTiles file. */
        get: operations["export_map_area"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/areas/{id}/pause": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Pauses the download of an area. */
        post: operations["pause_map_area"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/areas/{id}/resume": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Resumes an area and retries failed tiles. */
        post: operations["resume_map_area"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/capabilities": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Returns the capabilities of a WMS or WMTS, which need not be configured as a source. */
        post: operations["ask_map_capabilities"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/config": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns all settings of the configuration file, without keys. */
        get: operations["get_map_config"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/files": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the files in the maps folder. */
        get: operations["list_map_files"];
        put?: never;
        /**
         * Uploads a file to the maps folder; its name must have an extension that `GET /maps/kinds` lists. The body is the
         *     file, at most 8 GiB. The answer proposes settings; the source exists only once they are sent back.
         */
        post: operations["take_map_file"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/kinds": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the kinds of sources: their settings, possible roles, and accepted files. */
        get: operations["list_map_kinds"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/order": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Sets the drawing order. */
        put: operations["order_map_sources"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/presets": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists well-known sources with their terms of use. */
        get: operations["list_map_presets"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/sources": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Lists the map sources in drawing order, with their grids and their health. The configuration file is reloaded if it
         *     has been edited.
         */
        get: operations["list_map_sources"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/sources/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /**
         * Creates a source, or replaces the one with that id. Comments in the file are kept. An absent key keeps the stored
         *     one; an empty key removes it.
         */
        put: operations["put_map_source"];
        post?: never;
        /** Removes a source. */
        delete: operations["delete_map_source"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/sources/{id}/attribution": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Attributions for a view of a source; most sources have the same ones everywhere. */
        get: operations["get_map_attribution"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/sources/{id}/cache": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /** Clears a source's cache, except for its offline areas. */
        delete: operations["clear_map_cache"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/sources/{id}/check": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Requests one tile from a source, bypassing its cache, and returns the source's health. */
        post: operations["check_map_source"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/maps/sources/{id}/image": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the image file of a source of kind `image`. */
        get: operations["get_map_image"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/networks": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the fleets that this station is in, and whether their networks are connected. */
        get: operations["list_networks"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/operations": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists running and recently ended operations, without their results. */
        get: operations["list_operations"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/operations/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns an operation, with its result once it is done. */
        get: operations["get_operation"];
        put?: never;
        post?: never;
        /**
         * Cancels an operation; permitted for the session that started it and for the holder of control. The part of the plan
         *     concerned is unknown until it is read again.
         */
        delete: operations["cancel_operation"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/params/format": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Formats a `.param` file: one `NAME,value` per line, in the given order. */
        post: operations["format_params"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/params/parse": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Parses a parameter file of any supported format (`.param`, `.parm`, `.params`); the body is the file. */
        post: operations["parse_params"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/cameras": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists cameras in use on small planes. */
        get: operations["cameras"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/check": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Checks a plan for anything that would make it fail. */
        post: operations["check"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/complex-items": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Locates the items of each complex item in the mission, in the order of `complex_items`, with the design requests of
         *     surveys among them.
         */
        post: operations["complex_parts"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/fixes": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Finds changes of a plan's items, or of one vehicle parameter, that resolve its findings. Each is applied, checked
         *     and rehearsed first, which can take seconds.
         */
        post: operations["plan_fixes"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/format": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Formats a plan as a file. Parts of the plan that the file does not preserve are in the header `Vencejo-Notes`. */
        post: operations["format_plan"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/frame": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Converts altitudes of items to another frame. Where a reference level is unknown, an item keeps its number and is
         *     listed in `unconverted`.
         */
        post: operations["counted_from"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/landing": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Designs a landing: the items that end a mission, with computed altitudes. */
        post: operations["landing"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/landing/alternatives": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Proposes landings at a position, the best for this wind first: each direction of a runway, or of a fan of courses,
         *     with its circle on either side, and the reasons for and against it. Each is rehearsed from `coming_from`, else from
         *     home.
         */
        post: operations["alternatives"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/landing/move": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Moves one part of a landing and adapts the rest. */
        post: operations["moved_landing"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/learn": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Estimates the model of a plane from a recording of its flight, a `.tlog`: the body, or a file on the server's disk.
         *     It needs a minute or two in the air, with position, attitude and airspeed, in more than one direction. Values that
         *     the flight does not show are taken from the parameters.
         */
        post: operations["learn"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/parse": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Parses a plan file of any supported format; the body is the file. Assumptions and omissions are in the header
         *     `Vencejo-Notes`.
         */
        post: operations["parse"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/rehearse": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Rehearses a plan: the track that the plane would fly in a wind, when it reaches each item, and where it ends. */
        post: operations["rehearse"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/rehearse/spread": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Flies a plan many times in winds and with planes that differ from the expected ones: the corridor of the flights and
         *     the frequency of their endings. Such requests are processed one at a time; closing the connection cancels one.
         */
        post: operations["rehearse_many"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/separation": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Finds conflicts between planned flights. Each is rehearsed as its vehicle would fly it, starting from the ground at
         *     its home; the answer states these assumptions. Advisory only: no flight is changed.
         */
        post: operations["separate"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/survey": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Designs and rehearses a survey of an area or a corridor: the items, the position of each image, and the coverage. */
        post: operations["survey"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/way": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Returns the route of a plan's mission as drawn on the map: lines between positions, circles, jumps, lengths and
         *     courses; and its altitude profile with the terrain below. While a point is dragged, use the WebSocket (`plan_way`).
         */
        post: operations["way"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/plan/what-if": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Simulates what follows when the link, the battery or the engine fails, or a return is commanded, at a time in a plan
         *     or, for a vehicle in flight, from now on.
         */
        post: operations["what_if"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/recorder": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the state of the flight recorder; null when it is off. */
        get: operations["recorder"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/recordings": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the recordings on the server's disk, newest first; empty when this session is not recorded. */
        get: operations["list_recordings"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/recordings/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns a recording: before each frame, 8 bytes of big-endian microseconds since 1970. A file that is still being
         *     recorded ends where it ended when the request arrived.
         */
        get: operations["get_recording"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/recordings/{name}/keep": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Protects a recording from being deleted to make room for new ones, or ends the protection. */
        put: operations["keep"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/recordings/{name}/summary": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Summarizes a recording: its senders, its messages, and the events of its vehicles. */
        get: operations["summarize"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/replays": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the recordings that are being replayed. */
        get: operations["list_replays"];
        put?: never;
        /**
         * Replays a recording. Its aircraft appear as vehicles of their own, beside the live ones. A recording that is replayed
         *     already goes to the given position instead. Reading a recording of 2 GB takes some seconds.
         */
        post: operations["open_replay"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/replays/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        post?: never;
        /** Ends a replay; its vehicles disappear. */
        delete: operations["close_replay"];
        options?: never;
        head?: never;
        /** Pauses a replay, lets it go on, changes its speed, or goes to another position; answers once it is there. */
        patch: operations["change_replay"];
        trace?: never;
    };
    "/api/v1/replays/{id}/marks": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists when aircraft of a recording were armed or disarmed, or changed their mode; the first 500. Empty for a history file. */
        get: operations["list_marks"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/serial-ports": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the serial ports of the server's machine: autopilots on USB first, then adapters, then the others. */
        get: operations["list_serial_ports"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/session": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the session of the cookie. */
        get: operations["get_session"];
        put?: never;
        /** Opens a session, or returns the one of the cookie. An operator receives control when no session holds it. */
        post: operations["open_session"];
        /** Ends the session and releases control. */
        delete: operations["close_session"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/storage": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists storage faults, the flight recorder's first; empty when there are none. */
        get: operations["storage_problems"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/tiles/{source}/{z}/{x}/{y}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns a tile of a source's grid: level, column from the left, row from the top. `Vencejo-Tile` names its origin:
         *     `hit`, `stale` (from the cache because the source fails), `fetched`, `revalidated` or `file`.
         */
        get: operations["tile"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Lists the vehicles heard so far. */
        get: operations["list_vehicles"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the state of a vehicle. */
        get: operations["get_vehicle"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/abort-landing": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Aborts a landing and climbs: MAV_CMD_DO_GO_AROUND. */
        post: operations["abort_landing"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/altitude": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Changes the altitude of the present target: MAV_CMD_DO_CHANGE_ALTITUDE. For an ArduPlane; in AUTO it holds until
         *     the next item. One from before COMMAND_INT gets MISSION_ITEM with `current` = 3. Refused while the plane lands,
         *     or may do so in a mission that was not read: it would flare and stop its motor where it is.
         */
        post: operations["altitude"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/arm": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Arms. Done when a HEARTBEAT shows it; refused with the vehicle's reasons when its checks fail. */
        post: operations["arm"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/climb": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Climbs or sinks to a height: MAV_CMD_GUIDED_CHANGE_ALTITUDE. Only for an ArduPlane in GUIDED. */
        post: operations["climb"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/command/int": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Sends any command as COMMAND_INT. It is retransmitted only if repeating it is known to be safe. */
        post: operations["command_int"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/command/long": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Sends any command as COMMAND_LONG. It is retransmitted only if repeating it is known to be safe. */
        post: operations["command_long"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/control/keep": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Declines the request of another ground station for control of a remote vehicle that this one has. */
        post: operations["keep_vehicle_control"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/control/release": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Releases control of a remote vehicle: to the ground station that requests it, if any. Also withdraws a request. */
        post: operations["release_vehicle_control"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/control/request": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Requests control of a remote vehicle from the ground station that has it; takes it when none does. The request
         *     stands until it is granted, declined or withdrawn. For a vehicle on a link it is `POST /control/request`.
         */
        post: operations["request_vehicle_control"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/course": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Turns to a course over ground and stays on it: MAV_CMD_GUIDED_CHANGE_HEADING. Only for an ArduPlane in GUIDED,
         *     which no request enters for it.
         */
        post: operations["course"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/disarm": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Disarms. Done when a HEARTBEAT shows it. */
        post: operations["disarm"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/goto": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Flies to a position, at most 200 km from home or the vehicle, and circles there: MAV_CMD_DO_REPOSITION by
         *     COMMAND_INT. An ArduPlane from before COMMAND_INT gets MISSION_ITEM with `current` = 2 instead, which enters
         *     GUIDED by itself and knows neither radius nor sense nor speed. A fixed wing with PX4 gets MAV_CMD_DO_ORBIT for a
         *     radius or sense of its own. For a speed a plane gets MAV_CMD_DO_CHANGE_SPEED afterwards; if it refuses that, it
         *     flies to the position all the same.
         */
        post: operations["goto"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/home": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Moves home to a position, at most 200 km from the old one or the vehicle, or to where the vehicle is when none of
         *     its values is given: MAV_CMD_DO_SET_HOME. In flight it has to be confirmed.
         */
        post: operations["home"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/land": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Lands. A fixed wing, and any ArduPlane: jumps to the landing sequence of its mission (MAV_CMD_DO_LAND_START), an
         *     ArduPlane in AUTO to the beginning of a landing that is known to have no such mark; nothing is sent to one that
         *     flies its landing already, because it would begin it anew and turn away without climbing. Refused while it is
         *     disarmed, and for a PX4 on the ground. Others: mode LAND.
         */
        post: operations["land"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/loiter": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Circles (or hovers) here: mode LOITER. */
        post: operations["loiter"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/messages": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Sends any message as given, without waiting for an answer. Refused are numbers that no autopilot can interpret; while
         *     the mission may be mixed, messages that arm, start the mission or set its current item; and while it leads out of reach,
         *     or home and position are not known, those that have the vehicle follow it. A new altitude is refused while an ArduPlane
         *     lands, or may be landing in a mission that was not read.
         */
        post: operations["send_message"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/messages/{name}/rate": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        /** Sets the rate of a message, as `POST /vehicles/{id}/set-message-rate` does. */
        put: operations["set_rate_of_named_message"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/messages/{name}/request": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Requests one message from the vehicle and returns it. Needs no control, unlike `POST
         *     /vehicles/{id}/request-message`.
         */
        post: operations["request_named_message"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/mission/current": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Makes an item the current one: MAV_CMD_DO_SET_MISSION_CURRENT, or MISSION_SET_CURRENT for an older vehicle.
         *     Refused while an ArduPlane flies to its landing point: it would turn away without climbing first.
         */
        post: operations["mission_current"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/mission/pause": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Interrupts the mission: mode LOITER. */
        post: operations["mission_pause"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/mission/resume": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Goes on with the mission where it stands: mode AUTO. An ArduPlane that begins it anew (`MIS_RESTART` 1) is set
         *     to where it stood, and a PX4 that left it to return to the item that it left.
         */
        post: operations["mission_resume"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/mission/start": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Starts the mission: mode AUTO, after setting the current item when one is given. Never arms. Item 1 is the
         *     mission's beginning: its jump counters are set back too. An ArduPlane has to show a mission that runs, and is
         *     set to the item once more where it began anew (`MIS_RESTART` 1).
         */
        post: operations["mission_start"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/mode": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Changes the flight mode. Done when a HEARTBEAT shows it. */
        post: operations["mode"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/params": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Reads all parameters; they are the result of the operation. */
        get: operations["read_params"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/params/{name}": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Reads one parameter from the vehicle. */
        get: operations["get_param"];
        /** Writes one parameter; returns the value that the vehicle stored. */
        put: operations["set_param"];
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/plan/compare": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Compares a plan with the one on board: items added, removed and changed, at the vehicle's storage precision. Sends
         *     nothing to the vehicle.
         */
        post: operations["compare"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/plan/fence": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns this part of the plan on board, as far as it is known. Sends nothing to the vehicle: the station
         *     reads unknown parts by itself and reports changes with the WebSocket's `plan_state`.
         */
        get: operations["fence_on_board"];
        /**
         * Replaces this part of the plan on board by that of the given plan, and reads it back. Once the operation is
         *     done, the vehicle has it; the result of the operation is the plan on board. One with errors found by the checks
         *     is refused, and so is an empty part: DELETE clears it.
         */
        put: operations["upload_fence"];
        post?: never;
        /** Clears this part of the plan on board and verifies that it is empty. */
        delete: operations["clear_fence"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/plan/fence/read": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Reads this part of the plan on board; it is the result of the operation. */
        post: operations["download_fence"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/plan/mission": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns this part of the plan on board, as far as it is known. Sends nothing to the vehicle: the station
         *     reads unknown parts by itself and reports changes with the WebSocket's `plan_state`.
         */
        get: operations["mission_on_board"];
        /**
         * Replaces this part of the plan on board by that of the given plan, and reads it back. Once the operation is
         *     done, the vehicle has it; the result of the operation is the plan on board. One with errors found by the checks
         *     is refused, and so is an empty part: DELETE clears it.
         */
        put: operations["upload_mission"];
        post?: never;
        /** Clears this part of the plan on board and verifies that it is empty. */
        delete: operations["clear_mission"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/plan/mission/read": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Reads this part of the plan on board; it is the result of the operation. */
        post: operations["download_mission"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/plan/rally": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns this part of the plan on board, as far as it is known. Sends nothing to the vehicle: the station
         *     reads unknown parts by itself and reports changes with the WebSocket's `plan_state`.
         */
        get: operations["rally_on_board"];
        /**
         * Replaces this part of the plan on board by that of the given plan, and reads it back. Once the operation is
         *     done, the vehicle has it; the result of the operation is the plan on board. One with errors found by the checks
         *     is refused, and so is an empty part: DELETE clears it.
         */
        put: operations["upload_rally"];
        post?: never;
        /** Clears this part of the plan on board and verifies that it is empty. */
        delete: operations["clear_rally"];
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/plan/rally/read": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Reads this part of the plan on board; it is the result of the operation. */
        post: operations["download_rally"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/prepare-flight": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Prepares a flight, on the ground and disarmed: changes to a mode that arms where the present one does not, and
         *     sets the mission, when there is one, back to its beginning, its jump counters too. A text of ours says so
         *     before. Refused when armed or in the air. It neither arms nor starts; what is known of the vehicle
         *     (`progress.preparation`) tells before what it does.
         */
        post: operations["prepare_flight"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/profile": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /**
         * Returns the data with which this vehicle's plans are rehearsed, and the model estimated from its flight, which can
         *     be given to a rehearsal as its `profile`.
         */
        get: operations["profile"];
        put?: never;
        post?: never;
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/reboot": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Reboots the autopilot. Only when a fresh HEARTBEAT shows it disarmed. */
        post: operations["reboot"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/request-message": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Asks for one message once, and brings it: MAV_CMD_REQUEST_MESSAGE. Done when the message arrives. */
        post: operations["request_message"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/return-to-launch": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Returns to launch: mode RTL. */
        post: operations["return_to_launch"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/rival/follow": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Switches to the other vehicle that uses this system id: it is followed and commanded from now on, in place of the
         *     present one.
         */
        post: operations["follow_rival"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/set-message-rate": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Sets how often the vehicle sends a message, now and after each of its restarts: MAV_CMD_SET_MESSAGE_INTERVAL. It
         *     overrides other stations.
         */
        post: operations["set_message_rate"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/signing": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the signing state of a vehicle. */
        get: operations["get_signing"];
        put?: never;
        /**
         * Sets, replaces or removes a vehicle's signing key, and waits up to 5 s for its frames to confirm the change.
         *     Permitted only while it is disarmed. Until the confirmation, frames to it are signed as before.
         */
        post: operations["change_signing"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/speed": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /** Changes the speed: MAV_CMD_DO_CHANGE_SPEED. */
        post: operations["speed"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/switch-fence": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Switches the fence on board on or off, until its parameters or a restart do: MAV_CMD_DO_FENCE_ENABLE. Done when
         *     it is acknowledged; an ArduPlane without a fence refuses to switch it on. A PX4 has parameter GF_ACTION instead.
         */
        post: operations["switch_fence"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/takeoff": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Takes off. A fixed-wing ArduPilot: sets parameter `TKOFF_ALT`, then mode TAKEOFF; it starts to roll when it is
         *     armed (or at once when it already is). Others: MAV_CMD_NAV_TAKEOFF, for which they must be armed.
         */
        post: operations["takeoff"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/texts": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        /** Returns the newest status texts of a vehicle, oldest first. */
        get: operations["list_texts"];
        put?: never;
        /** Adds a text of ours to those of the vehicle, shown to all clients of this station. Nothing is sent. */
        post: operations["texts"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
    "/api/v1/vehicles/{id}/velocity": {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        get?: never;
        put?: never;
        /**
         * Flies at a velocity: SET_POSITION_TARGET_LOCAL_NED, relative to the heading. Only for an ArduCopter in GUIDED or
         *     a PX4 in OFFBOARD, which no request enters for it. It has no answer: done when it is sent. The vehicle stops by
         *     itself when it is not repeated (ArduCopter after GUID_TIMEOUT, 3 s; PX4 after 0.5 s).
         */
        post: operations["velocity"];
        delete?: never;
        options?: never;
        head?: never;
        patch?: never;
        trace?: never;
    };
}
export type webhooks = Record<string, never>;
export interface components {
    schemas: {
        /** @description Acknowledgement of a command that the vehicle accepted. */
        Acknowledged: {
            /**
             * Format: int32
             * @description `result_param2` of the COMMAND_ACK; its meaning depends on the command.
             */
            result_param2: number;
        };
        /** @description Stored history of one aircraft. */
        AircraftHistory: {
            /** @description Files by name, which is also by time if the clock was set. */
            files: components["schemas"]["HistoryFile"][];
            /** @description Ranges missing on the ground; null when there is no inventory. */
            gaps: components["schemas"]["HistoryGap"][] | null;
            /** @description Name of the aircraft. */
            name: string;
            /** @description The fleet, or `_board` for the history that this computer records on board an aircraft. */
            place: string;
            /** @description Why the gaps are unknown, in English: the inventory is damaged. */
            problem: string | null;
            /**
             * @description Total number of records of each stream that were stored; some may have been deleted since, to make room. Empty
             *     when there is no inventory, as on board, where everything is recorded.
             */
            records: {
                [key: string]: number;
            };
        };
        /**
         * @description Lift, drag and thrust per mass, at indicated airspeeds.
         *
         *     The drag polar is parabolic, D = a V² + b n² V⁻² (J. D. Anderson, *Aircraft Performance and Design*, eq. 5.9).
         *
         *     Where it is known how much a propeller pulls standing still, thrust is T = Ts θ² − (Ts − Tf) θ V / Vc of throttle θ
         *     and airspeed V, and nothing at least: ρ n² D⁴ C_T with revolutions n as the throttle and C_T linear in the advance
         *     ratio V / (n D), as small propellers have it (J. B. Brandt, M. S. Selig, *Propeller Performance Data at Low Reynolds
         *     Numbers*, AIAA 2011-1255). Elsewhere it is taken as independent of speed, which lies between a jet's and a
         *     propeller's of constant power, and as linear in throttle on both sides of cruise.
         */
        Airframe: {
            /**
             * Format: double
             * @description Angle of attack above that of no lift in level flight at it, rad.
             */
            attack_rad: number;
            /**
             * Format: double
             * @description Airspeed that the following is given at, m/s.
             */
            cruise_m_s: number;
            /**
             * Format: double
             * @description Drag in level flight at it, m/s².
             */
            drag_m_s2: number;
            /**
             * Format: double
             * @description Deceleration on the ground after a landing in addition to its drag, m/s²: its wheels, brakes, or belly; `None`:
             *     not known, and it slides.
             */
            ground_drag_m_s2: number | null;
            /**
             * Format: double
             * @description Part of that drag which lift induces, 0 to 1.
             */
            induced: number;
            /**
             * @description Whether [`Self::pitot`] is the air's own true over equivalent airspeed: ArduPilot's simulator divides by it
             *     twice (`SIM_Aircraft::update_eas_airspeed`, `SITL_State::_update_airspeed`), and its forces follow.
             */
            is_simulated: boolean;
            /**
             * Format: double
             * @description Pitch of the fuselage in level flight at it, rad.
             */
            level_pitch_rad: number;
            /** @description Where this profile comes from. */
            origin: components["schemas"]["Origin"];
            /**
             * Format: double
             * @description True airspeed over what the autopilot takes for it; 1 where the pitot tube is right.
             */
            pitot: number;
            /**
             * Format: double
             * @description Electrical power of level flight at it, W; `None`: not known, and no energy is computed.
             */
            power_cruise_w: number | null;
            /**
             * Format: double
             * @description Exponent of the power over the throttle: 3 for a propeller whose speed follows the throttle alone (momentum
             *     theory), less where it moves on; measured mostly 2 to 3.
             */
            power_exponent: number;
            /**
             * Format: double
             * @description How much a turn skids: the side force of the slip that yawing brings, over the centripetal force. A bank turns
             *     the plane `1 / (1 + skid)` as fast as a coordinated turn does; 0, coordinated, unless learned. That of
             *     ArduPilot's simulator holds at sea level.
             */
            skid: number;
            /**
             * Format: double
             * @description Throttle of level flight at it, 0 to 1.
             */
            throttle_cruise: number;
            /**
             * Format: double
             * @description Thrust at full throttle, m/s².
             */
            thrust_full_m_s2: number;
            /**
             * Format: double
             * @description The same standing still, no less; `None`: not known, or no propeller's.
             */
            thrust_static_m_s2: number | null;
            /**
             * Format: double
             * @description Voltage of the battery in flight, V; `None`: not known.
             */
            voltage_v: number | null;
        };
        /** @description AIRSPEED of the sensor heard last. */
        AirspeedSensor: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Calibrated airspeed.
             */
            airspeed_m_s: number | null;
            /**
             * Format: double
             * @description Differential pressure.
             */
            differential_pa: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: int32
             * @description Sensor id.
             */
            id: number;
            /** @description Whether the sensor reports that it is unhealthy. */
            is_unhealthy: boolean;
            /** @description Whether the autopilot uses it. */
            is_used: boolean;
            /**
             * Format: double
             * @description Temperature.
             */
            temperature_c: number | null;
        };
        /**
         * @description The reference of an altitude in a request.
         * @enum {string}
         */
        AltFrame: "amsl" | "home" | "terrain";
        /** @description An offline area to create or to estimate. */
        AreaRequest: {
            /**
             * Format: int32
             * @description Finest level of the source's grid; for XYZ the zoom.
             */
            max_level: number;
            /**
             * Format: int32
             * @description Coarsest level of the source's grid; for XYZ the zoom.
             */
            min_level: number;
            /** @description Display name. */
            name: string;
            /** @description Area to cover. */
            shape: components["schemas"]["AreaShape"];
            /** @description Id of the map source. */
            source: string;
        };
        /** @description Shape of an offline area. */
        AreaShape: (components["schemas"]["MapBounds"] & {
            /** @enum {string} */
            kind: "box";
        }) | {
            /** @enum {string} */
            kind: "polygon";
            /** @description Corners in order. */
            points: components["schemas"]["LatLon"][];
        } | {
            /**
             * Format: double
             * @description Width of the buffer on each side.
             */
            buffer_m: number;
            /** @enum {string} */
            kind: "route";
            /** @description Points in order. */
            points: components["schemas"]["LatLon"][];
        } | {
            /**
             * Format: double
             * @description Width of the buffer on each side.
             */
            buffer_m: number;
            /** @enum {string} */
            kind: "plan";
            /** @description The plan. */
            plan: components["schemas"]["Plan"];
        };
        /** @description Assessment of a plan. */
        Assessment: {
            /** @description Errors and doubts found in it. */
            findings: components["schemas"]["Finding"][];
            rehearsal: components["schemas"]["Rehearsal"] | null;
            /** @description Its mission as flown. */
            trip: components["schemas"]["Trip"];
        };
        /** @description Assumptions about a flight. */
        AssumedFlight: {
            /** @description How its rehearsal ends. */
            ending: components["schemas"]["Ending"];
            /**
             * Format: double
             * @description Time at which its rehearsal ends.
             */
            ends_s: number;
            /**
             * Format: double
             * @description Time of its start, on the ground at its home.
             */
            starts_s: number;
            /**
             * Format: int32
             * @description The vehicle.
             */
            vehicle: number | null;
        };
        /** @description ATTITUDE: body (forward, right, down) in the local frame (north, east, down), Tait-Bryan ZYX. */
        Attitude: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Nose up positive, -pi/2 to pi/2.
             */
            pitch_rad: number | null;
            /**
             * Format: double
             * @description Body rate about the right axis.
             */
            pitch_rate_rad_s: number | null;
            /**
             * Format: double
             * @description Right wing down positive, -pi to pi.
             */
            roll_rad: number | null;
            /**
             * Format: double
             * @description Body rate about the forward axis.
             */
            roll_rate_rad_s: number | null;
            /**
             * Format: double
             * @description Clockwise from true north, -pi to pi.
             */
            yaw_rad: number | null;
            /**
             * Format: double
             * @description Body rate about the down axis.
             */
            yaw_rate_rad_s: number | null;
        };
        /** @description AUTOPILOT_VERSION. */
        AutopilotVersion: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: int64
             * @description `MAV_PROTOCOL_CAPABILITY` bits.
             */
            capabilities: number;
            /** @description Version of the flight software, such as `"4.6.3"`. */
            flight_sw: string;
            /** @description First eight characters of the git hash of the flight software. */
            git_hash: string;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * @description Unique id of the hardware, 64 bits; in JSON a string of decimal digits, which a JSON number could not hold
             *     exactly.
             */
            uid: string | null;
        };
        /** @description BATTERY_STATUS of one battery. */
        Battery: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Energy used.
             */
            consumed_j: number | null;
            /**
             * Format: double
             * @description Charge used.
             */
            consumed_mah: number | null;
            /**
             * Format: double
             * @description Current, discharge positive.
             */
            current_a: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: int32
             * @description Battery id, from 0.
             */
            id: number;
            /**
             * Format: double
             * @description Charge left, 0 to 100 %.
             */
            remaining_pct: number | null;
            /**
             * Format: double
             * @description Temperature.
             */
            temperature_c: number | null;
            /**
             * Format: double
             * @description Time left at this rate.
             */
            time_remaining_s: number | null;
            /**
             * Format: double
             * @description Voltage of the pack: the sum of the reported voltages.
             */
            voltage_v: number | null;
        };
        /**
         * @description Why the remaining charge is unknown.
         * @enum {string}
         */
        BatteryLack: "power" | "capacity" | "voltage";
        /** @description Charge of a battery after a flight. */
        BatteryLeft: {
            /**
             * Format: double
             * @description Energy of a full battery.
             */
            capacity_wh: number;
            /**
             * Format: double
             * @description Time at which it is empty, seconds since the beginning of the rehearsed flight; null when it does not become
             *     empty.
             */
            empty_s: number | null;
            /**
             * Format: double
             * @description Charge at the end, percent of the capacity; negative when the flight needs more than the battery holds.
             */
            left_pct: number;
            /**
             * Format: double
             * @description Charge that should remain, percent of the capacity.
             */
            reserve_pct: number;
        };
        /** @description A user's values for a battery, in place of those of parameters and battery monitor; `None`: as those. */
        BatterySettings: {
            /**
             * Format: double
             * @description Charge of a full one, mAh, 1 to 1,000,000.
             * @default null
             */
            capacity_mah: number | null;
            /**
             * Format: double
             * @description Charge at the start, % of its capacity, 0 to 100.
             * @default null
             */
            charge_pct: number | null;
            /**
             * Format: double
             * @description Power that is drawn from it in level flight at cruise, W, 0.1 to 1,000,000 ([`Airframe::power_cruise_w`]).
             * @default null
             */
            power_cruise_w: number | null;
            /**
             * Format: double
             * @description What should be left at the landing, % of its capacity, 0 to 100.
             * @default null
             */
            reserve_pct: number | null;
            /**
             * Format: double
             * @description Its voltage while the engine runs, V, 1 to 1,000.
             * @default null
             */
            voltage_v: number | null;
        };
        /** @description Forecast of a flight, made when following it began, taken from an answer about the present flight. */
        Beginning: {
            /** @description `now` of that answer. */
            now: components["schemas"]["FlightNow"];
            /** @description Track of its `ahead`. */
            track: components["schemas"]["ExpectedTrack"];
        };
        /** @description Sensor and lens of a camera. */
        Camera: {
            /**
             * Format: double
             * @description Real focal length, not its equivalent on film, mm, 0.5 to 2,000.
             */
            focal_length_mm: number;
            /**
             * Format: int32
             * @description Pixels across the height, 16 to 100,000.
             */
            image_height_px: number;
            /**
             * Format: int32
             * @description Pixels across the width, 16 to 100,000.
             */
            image_width_px: number;
            /**
             * Format: double
             * @description Least time between two pictures, s, 0 to 60; 0: not known.
             */
            min_interval_s: number;
            /**
             * Format: double
             * @description Height of the sensor, mm, 0.5 to 200.
             */
            sensor_height_mm: number;
            /**
             * Format: double
             * @description Width of the sensor, mm, 0.5 to 200: the side that has `image_width_px`.
             */
            sensor_width_mm: number;
        };
        /** @description A camera. */
        CameraInfo: {
            /**
             * Format: double
             * @description Age of the newest image.
             */
            age_s: number | null;
            /**
             * Format: double
             * @description Recent bit rate of the source.
             */
            bitrate_bit_s: number | null;
            codec: components["schemas"]["VideoCodec"] | null;
            /**
             * Format: int32
             * @description Image height, pixels.
             */
            height: number | null;
            /** @description Name, as used in the camera's paths. */
            name: string;
            /**
             * Format: double
             * @description Recent frame rate.
             */
            rate_hz: number | null;
            /** @description Why no images arrive, in English; null when they do. */
            reason: string | null;
            recording: components["schemas"]["CameraRecording"] | null;
            /** @description Source of its images, without passwords. */
            source: string;
            /** @description State of the image stream. */
            state: components["schemas"]["CameraState"];
            /**
             * Format: int32
             * @description Number of viewers.
             */
            viewers: number;
            /**
             * Format: int32
             * @description Image width, pixels.
             */
            width: number | null;
        };
        /** @description Text messages on a camera's stream, beside the images. */
        CameraMessage: (components["schemas"]["CameraInfo"] & {
            /** @enum {string} */
            type: "camera";
        }) | {
            /** @enum {string} */
            type: "clock";
            /**
             * Format: int64
             * @description Microseconds since 1970, UTC.
             */
            unix_us: number;
        };
        /** @description A recording of a camera. */
        CameraRecording: {
            /**
             * Format: int64
             * @description File size.
             */
            bytes: number;
            /**
             * Format: double
             * @description Duration.
             */
            duration_s: number;
            /** @description File name, in the data folder of the machine to which the camera is connected. */
            file: string;
            /** @description Why it ended unexpectedly, in English; null while it is being recorded. */
            problem: string | null;
        };
        /**
         * @description State of a camera's image stream.
         * @enum {string}
         */
        CameraState: "standby" | "starting" | "live" | "stalled" | "dead";
        /** @description A map service whose capabilities are wanted. */
        CapabilitiesRequest: {
            /** @description Key that replaces `{key}` in the address. */
            key?: string | null;
            /** @description `wms` or `wmts`. */
            kind: components["schemas"]["MapSourceKind"];
            /** @description Whether the service is in the local network; otherwise private addresses are refused. */
            local_network?: boolean;
            /** @description Address of the service, or any of its request addresses. */
            url: string;
        };
        /**
         * @description Cause of an error. `code` is stable and is the last part of the problem's `type`; the other fields hold the
         *     values of the English `detail`, so that clients can show it in another language. Fields that contain English
         *     text say so.
         */
        Cause: {
            /** @enum {string} */
            code: "host";
            /** @description The host in the header; null when it cannot be read. */
            host: string | null;
        } | {
            /** @enum {string} */
            code: "origin";
            /** @description Origin of that page. */
            origin: string;
        } | {
            /** @enum {string} */
            code: "no-session";
        } | {
            /** @enum {string} */
            code: "bad-token";
        } | {
            /** @enum {string} */
            code: "role";
        } | {
            /** @enum {string} */
            code: "control";
            /** @description Name of the session that holds control; null when there is none. */
            holder: string | null;
        } | {
            /** @enum {string} */
            code: "vehicle-control";
            /** @description Name of the operator who has control, after that of the ground station. */
            holder: string;
            /** @description Name of the vehicle. */
            vehicle: string;
        } | {
            /**
             * @description The dangerous action: `force-arm`, `force-disarm`, `disarm-in-flight`, `terminate`, `clear-mission`,
             *     `clear-fence`, `clear-rally`, `clear-all`, `reboot`, `fence-off`, `erase`, `write-files` or `move-home`.
             */
            act: string;
            /** @enum {string} */
            code: "needs-confirmation";
            /** @description Value to send; valid once, for this session, this vehicle and this action. */
            confirmation: string;
            /**
             * Format: double
             * @description Validity of the confirmation.
             */
            valid_s: number;
            /**
             * Format: int32
             * @description Id of the vehicle concerned.
             */
            vehicle: number;
        } | {
            /** @enum {string} */
            code: "bad-confirmation";
        } | {
            /** @enum {string} */
            code: "too-many";
            /**
             * Format: int64
             * @description The limit.
             */
            limit: number;
            /** @description Kind of the limit. */
            what: components["schemas"]["Crowd"];
        } | {
            /** @enum {string} */
            code: "closed";
        } | {
            /** @enum {string} */
            code: "signing-no-keys";
        } | {
            /** @enum {string} */
            code: "signing-storage";
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "signing-key-name";
            /** @description Name of the key. */
            name: string;
        } | {
            /** @enum {string} */
            code: "signing-state";
            /** @description Whether the vehicle signs. */
            signs: boolean;
        } | {
            /** @description Whether the vehicle is armed; null when unknown. */
            armed: boolean | null;
            /** @enum {string} */
            code: "signing-not-disarmed";
        } | {
            /** @enum {string} */
            code: "signing-not-private";
            /** @description Name of the link. */
            link: string;
        } | {
            /** @enum {string} */
            code: "signing-busy";
        } | {
            /** @enum {string} */
            code: "signing-refused";
            /** @description The vehicle's own text. */
            text: string;
        } | {
            /** @enum {string} */
            code: "signing-unproven";
        } | {
            /** @enum {string} */
            code: "invalid-request";
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "media-type";
        } | {
            /** @enum {string} */
            code: "body-too-large";
        } | {
            /** @enum {string} */
            code: "body-too-slow";
        } | {
            /** @enum {string} */
            code: "tokens-slowed";
            /**
             * Format: int64
             * @description Time until the next token is checked.
             */
            wait_s: number;
        } | {
            /** @enum {string} */
            code: "method";
        } | {
            /** @enum {string} */
            code: "not-found";
            /** @description Name or id of the resource. */
            name: string;
            /** @description Kind of the resource. */
            what: components["schemas"]["Thing"];
        } | {
            /** @enum {string} */
            code: "invalid-value";
            /** @description What is accepted, in English. */
            expected: string;
            /** @description Name of the field. */
            field: string;
            /** @description The value. */
            value: string;
        } | {
            /** @enum {string} */
            code: "recording-as-link";
        } | {
            /** @enum {string} */
            code: "heartbeat-follows-operator";
        } | {
            /** @enum {string} */
            code: "internal";
        } | {
            /** @enum {string} */
            code: "camera";
            /** @description Name of the camera. */
            name: string;
            /** @description The reason, in English. */
            reason: string;
        } | {
            /** @enum {string} */
            code: "link-address";
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "recorder";
            /** @description The operating system's message. */
            reason: string;
        } | {
            /** @enum {string} */
            code: "no-vehicle";
            /**
             * Format: double
             * @description Time waited.
             */
            waited_s: number;
        } | {
            /** @enum {string} */
            code: "not-sent";
            /** @description Name of the message. */
            message: string;
        } | {
            /** @enum {string} */
            code: "command-refused";
            /** @description Name of the command without `MAV_CMD_`, else its number. */
            command: string;
            /** @description Name of the mode that permits arming, where another mode would; otherwise null. */
            cure_mode: string | null;
            /** @description Name of the `MAV_RESULT` without that prefix, such as `DENIED`. */
            result: string;
        } | {
            /** @enum {string} */
            code: "remote-refused";
            /** @description Name of the vehicle. */
            vehicle: string;
            /** @description The reason, in English. */
            why: string;
        } | {
            /** @enum {string} */
            code: "replayed";
            /** @description Id or name of the vehicle. */
            vehicle: string;
        } | {
            /**
             * Format: int32
             * @description Number of times that it was sent.
             */
            attempts: number;
            /** @enum {string} */
            code: "command-timeout";
            /** @description Name of the command without `MAV_CMD_`, else its number. */
            command: string;
        } | {
            /** @enum {string} */
            code: "not-confirmed";
            /** @description Name of the command without `MAV_CMD_`, else its number. */
            command: string;
            /** @description Observed state, in English. */
            observed: string;
            /** @description Expected state, in English. */
            wanted: string;
            /**
             * Format: double
             * @description Time waited for the effect.
             */
            within_s: number;
        } | {
            /** @enum {string} */
            code: "message-not-received";
            /** @description Name of the message, else its id. */
            message: string;
        } | {
            /**
             * Format: double
             * @description Time since the vehicle was last heard.
             */
            age_s: number;
            /** @enum {string} */
            code: "vehicle-lost";
        } | {
            /** @enum {string} */
            code: "command-busy";
            /** @description Name of the command without `MAV_CMD_`, else its number. */
            command: string;
        } | {
            /** @enum {string} */
            code: "transfer-busy";
            /** @description The running transfer, in English. */
            running: string;
        } | {
            /** @enum {string} */
            code: "unknown-mode";
            /** @description Name of the requested mode. */
            mode: string;
            /** @description Names of similar modes. */
            suggestions: string[];
        } | {
            /** @description The action, in English. */
            action: string;
            /** @enum {string} */
            code: "no-mode-for";
        } | {
            /** @enum {string} */
            code: "plan-unknown";
            /** @description The plan concerned. */
            plan: components["schemas"]["PlanKind"];
            reason: components["schemas"]["PlanUncertainty"] | null;
        } | {
            /** @enum {string} */
            code: "out-of-reach";
            /**
             * Format: double
             * @description To home or the vehicle, whichever is nearer.
             */
            distance_m: number;
            /** @description Whether it is in reach with latitude and longitude swapped. */
            is_swapped: boolean;
            /**
             * Format: int64
             * @description The first such item, counted from 1.
             */
            item: number;
        } | {
            /** @enum {string} */
            code: "too-old";
            /** @description The unsupported function, in English. */
            what: string;
        } | {
            /** @description The action, in English. */
            action: string;
            /** @enum {string} */
            code: "armed";
        } | {
            /** @description The action, in English. */
            action: string;
            /** @enum {string} */
            code: "in-the-air";
        } | {
            /** @description The action, in English. */
            action: string;
            /** @enum {string} */
            code: "not-flying";
        } | {
            /** @description The action that is not possible meanwhile, in English. */
            action: string;
            /** @enum {string} */
            code: "landing";
            /** @description Whether it is known to be landing. */
            is_known: boolean;
        } | {
            /** @enum {string} */
            code: "home-unknown";
        } | {
            /** @enum {string} */
            code: "rebooted";
        } | {
            /** @enum {string} */
            code: "cancelled";
        } | {
            /** @enum {string} */
            code: "transfer-timeout";
            /** @description The unanswered step, in English. */
            step: string;
            /**
             * Format: double
             * @description Time waited.
             */
            waited_s: number;
        } | {
            /** @enum {string} */
            code: "unreached";
            /**
             * Format: double
             * @description Time without an answer.
             */
            waited_s: number;
        } | {
            /**
             * Format: int32
             * @description Number of attempts.
             */
            attempts: number;
            /** @enum {string} */
            code: "no-progress";
            /** @description The current step, in English. */
            step: string;
        } | {
            /** @enum {string} */
            code: "plan-refused";
            /**
             * Format: int32
             * @description The item that was most likely refused, counted from 1 (0 is the home of an ArduPilot's mission); null when unknown.
             */
            item: number | null;
            /** @description The plan concerned. */
            plan: components["schemas"]["PlanKind"];
            /** @description Name of the `MAV_MISSION_RESULT` without `MAV_MISSION_`. */
            result: string;
        } | {
            /** @enum {string} */
            code: "plan-mismatch";
            /**
             * Format: int64
             * @description Number of differences.
             */
            differences: number;
            /** @description The plan concerned. */
            plan: components["schemas"]["PlanKind"];
        } | {
            /** @enum {string} */
            code: "mission-rejected";
        } | {
            /** @enum {string} */
            code: "unverified";
            /** @description The plan concerned. */
            plan: components["schemas"]["PlanKind"];
        } | {
            /** @enum {string} */
            code: "only-mission";
            /** @description The requested plan. */
            plan: components["schemas"]["PlanKind"];
            /** @description Why it is not accepted. */
            reason: components["schemas"]["OnlyMissionReason"];
        } | {
            /** @enum {string} */
            code: "not-cleared";
            /**
             * Format: int32
             * @description Number of remaining items.
             */
            count: number;
            /** @description The plan concerned. */
            plan: components["schemas"]["PlanKind"];
        } | {
            /** @enum {string} */
            code: "too-large";
            /**
             * Format: int64
             * @description Its size or number of items.
             */
            count: number;
            /**
             * Format: int64
             * @description Largest number accepted.
             */
            limit: number;
            /** @description What is too large, in English. */
            what: string;
        } | {
            /** @enum {string} */
            code: "vehicle-file";
            /** @description Path of the file. */
            path: string;
        } | {
            /** @enum {string} */
            code: "files-busy";
            /** @description Path of the requested file. */
            path: string;
        } | {
            /** @enum {string} */
            code: "unknown-param";
            /** @description Name of the parameter. */
            name: string;
            /** @description Whether the vehicle said so; otherwise it did not answer. */
            told: boolean;
        } | {
            /** @enum {string} */
            code: "param-refused";
            /** @description Name of the parameter. */
            name: string;
            /** @description The reason, in English. */
            reason: string;
        } | {
            /**
             * Format: double
             * @description Value that was sent.
             */
            asked: number;
            /** @enum {string} */
            code: "param-not-kept";
            /**
             * Format: double
             * @description Value that the vehicle has.
             */
            kept: number;
            /** @description Name of the parameter. */
            name: string;
        } | {
            /** @enum {string} */
            code: "invalid-param";
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "plan-unsound";
            /**
             * Format: int64
             * @description Number of errors.
             */
            errors: number;
        } | {
            /** @enum {string} */
            code: "not-on-earth";
            /**
             * Format: double
             * @description Given latitude; null when it is not a number.
             */
            lat_deg: number | null;
            /**
             * Format: double
             * @description Given longitude; null when it is not a number.
             */
            lon_deg: number | null;
        } | {
            /** @enum {string} */
            code: "landing-direction";
            /**
             * Format: double
             * @description Smallest distance at which a preceding position gives a direction.
             */
            nearest_m: number;
        } | {
            /** @enum {string} */
            code: "bad-survey";
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "survey-crosses";
            /**
             * Format: int64
             * @description Corner at which one side begins, counted from 1.
             */
            one: number;
            /**
             * Format: int64
             * @description Corner at which the other side begins, counted from 1.
             */
            other: number;
        } | {
            /** @enum {string} */
            code: "survey-items";
            /**
             * Format: int64
             * @description Smallest number of items needed.
             */
            count: number;
            /**
             * Format: int64
             * @description Largest number that the vehicle can store.
             */
            max: number;
        } | {
            /**
             * Format: double
             * @description Airspeed of the plane.
             */
            airspeed_m_s: number;
            /** @enum {string} */
            code: "survey-wind";
            /**
             * Format: double
             * @description Course of the lines, from true north.
             */
            course_deg: number;
            /**
             * Format: double
             * @description Wind speed.
             */
            wind_m_s: number;
        } | {
            /**
             * Format: double
             * @description Airspeed of the plane.
             */
            airspeed_m_s: number;
            /** @enum {string} */
            code: "landing-wind";
            /**
             * Format: double
             * @description Course of the final leg, from true north.
             */
            course_deg: number;
            /**
             * Format: double
             * @description Wind speed.
             */
            wind_m_s: number;
        } | {
            /** @enum {string} */
            code: "bad-item";
            /** @description Name of its command without `MAV_CMD_`. */
            command: string;
            /** @description Name of the field. */
            field: string;
            /** @description The reason, in English. */
            problem: string;
            /**
             * Format: int32
             * @description Sequence number of the item, with home as 0.
             */
            seq: number;
            /**
             * Format: double
             * @description Value of the field; null when it is not a number.
             */
            value: number | null;
        } | {
            /** @enum {string} */
            code: "bad-plan";
            /**
             * Format: int64
             * @description The item or zone, counted from 1; null when the problem concerns the whole plan.
             */
            item: number | null;
            plan: components["schemas"]["PlanKind"] | null;
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "bad-file";
            /** @description Position in the file: `line 4`, or a path in JSON; null when the problem concerns the whole file. */
            place: string | null;
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "no-maps";
        } | {
            /** @enum {string} */
            code: "no-source";
            /** @description Id of the source. */
            source: string;
        } | {
            /** @enum {string} */
            code: "no-tile";
        } | {
            /** @enum {string} */
            code: "source-key";
            /** @description Id of the source. */
            source: string;
        } | {
            /** @enum {string} */
            code: "source-invalid";
            /** @description The reason, in English. */
            problem: string;
            /** @description Id of the source. */
            source: string;
        } | {
            /** @enum {string} */
            code: "source-settings";
            /** @description One problem per faulty field, in English; each names the field. */
            problems: string[];
            /** @description Id of the source. */
            source: string;
        } | {
            /** @enum {string} */
            code: "source-file";
            /** @description The problem, with its line, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "source-failed";
            /** @description The service's own text where it sent one. */
            problem: string;
            /** @description Host of the service. */
            service: string;
            /**
             * Format: int32
             * @description HTTP status; null when the status was not the problem.
             */
            status: number | null;
        } | {
            /** @enum {string} */
            code: "source-local";
            /** @description Whether the setting `local_network` of the source would permit it. */
            is_permissible: boolean;
            /** @description The reason and the remedy, in English. */
            problem: string;
            /** @description Host of the service. */
            service: string;
        } | {
            /** @enum {string} */
            code: "source-timeout";
            /** @description Host of the service. */
            service: string;
            /**
             * Format: int64
             * @description Time waited.
             */
            waited_s: number;
        } | {
            /** @enum {string} */
            code: "source-offline";
            /** @description The reason, in English. */
            problem: string;
            /**
             * Format: int64
             * @description Time until the next attempt.
             */
            retry_s: number;
            /** @description Host of the service. */
            service: string;
            /** @description The reason, as far as it is known. */
            why: components["schemas"]["MapUnreached"];
        } | {
            /** @enum {string} */
            code: "source-busy";
        } | {
            /** @enum {string} */
            code: "offline-refused";
            /** @description The reason, in English. */
            problem: string;
            /** @description Id of the source. */
            source: string;
        } | {
            /** @enum {string} */
            code: "area-too-large";
            /**
             * Format: int64
             * @description Largest number accepted.
             */
            limit: number;
            /**
             * Format: int64
             * @description Tiles in the area.
             */
            tiles: number;
        } | {
            /** @enum {string} */
            code: "map-file";
            /** @description Name of the file. */
            name: string;
            /** @description The reason, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "map-storage";
            /** @description The error message, in English. */
            problem: string;
        } | {
            /** @enum {string} */
            code: "low-space";
            /**
             * Format: int64
             * @description Megabytes that must stay free.
             */
            floor_mb: number;
            /**
             * Format: int64
             * @description Free megabytes.
             */
            free_mb: number;
        } | {
            /** @description Name of the session that changed it. */
            by: string;
            /** @enum {string} */
            code: "draft-conflict";
            /**
             * Format: int64
             * @description Current revision of the draft.
             */
            revision: number;
        };
        /** @description Request to change a vehicle's signing. */
        ChangeSigning: {
            /** @description Action to carry out. */
            act: components["schemas"]["SigningAct"];
            /** @description Whether the key may be sent over a link that others can listen to. */
            any_link?: boolean;
            /**
             * Format: int32
             * @description The vehicle's system id, repeated as a confirmation.
             */
            confirm_system_id: number;
        };
        /**
         * @description What has changed in an item.
         * @enum {string}
         */
        ChangedField: "command" | "place" | "height" | "parameters";
        /**
         * @description Meaning of an enumerated parameter value.
         * @enum {string}
         */
        ChoiceWord: "off" | "on" | "clockwise" | "counter-clockwise" | "centre" | "tangent" | "airspeed" | "groundspeed" | "climb" | "descent" | "whenever" | "above" | "below" | "floor-off" | "deploy" | "release" | "grab" | "low" | "middle" | "high" | "hover" | "cruise";
        /** @description How high above the ground the plane passes somewhere. */
        Clearance: {
            /**
             * Format: double
             * @description Height above the ground, metres.
             */
            clearance_m: number;
            /**
             * Format: double
             * @description Way flown until there, metres.
             */
            distance_m: number;
        };
        /** @description Messages from a client. */
        ClientMessage: {
            /**
             * Format: double
             * @description Messages per second, 1 to 50.
             */
            rate_hz: number;
            /** @enum {string} */
            type: "subscribe";
            /**
             * Format: int32
             * @description Id of the vehicle; it need not have been heard yet.
             */
            vehicle: number;
        } | {
            /** @enum {string} */
            type: "unsubscribe";
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } | {
            /** @enum {string} */
            type: "subscribe_roster";
        } | {
            /** @enum {string} */
            type: "unsubscribe_roster";
        } | {
            /** @description Names of the messages; all when absent. */
            names?: string[] | null;
            /**
             * Format: double
             * @description Highest rate of each message, 1 to 50 per second.
             */
            rate_hz: number;
            /** @enum {string} */
            type: "subscribe_messages";
            /**
             * Format: int32
             * @description Id of the vehicle; it need not have been heard yet.
             */
            vehicle: number;
        } | {
            /** @enum {string} */
            type: "unsubscribe_messages";
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } | {
            /**
             * Format: double
             * @description Clearance that the rehearsed flight should keep above the ground, 0 to 1000; 30 by default.
             */
            clearance_m?: number | null;
            /** @description The plan. */
            plan: components["schemas"]["Plan"];
            /** @description Plane for the rehearsal, in place of the vehicle's. */
            profile?: components["schemas"]["PlaneProfile"];
            rehearse_in?: components["schemas"]["PlanWind"] | null;
            /**
             * Format: int64
             * @description Request number, repeated in the answer.
             */
            seq: number;
            /** @enum {string} */
            type: "assess_plan";
            /**
             * Format: int32
             * @description Vehicle that is to fly the plan; a default ArduPlane when absent.
             */
            vehicle?: number | null;
        } | {
            /**
             * Format: double
             * @description Clearance to keep above the ground, 0 to 1000; 30 by default.
             */
            clearance_m?: number | null;
            /** @description The plan. */
            plan: components["schemas"]["Plan"];
            /**
             * Format: int64
             * @description Request number, repeated in the answer.
             */
            seq: number;
            /** @enum {string} */
            type: "plan_way";
            /**
             * Format: int32
             * @description Vehicle that is to fly the plan; a default ArduPlane when absent.
             */
            vehicle?: number | null;
        };
        /**
         * @description Category of a command.
         * @enum {string}
         */
        CommandCategory: "nav" | "condition" | "do" | "fence" | "rally";
        /** @description A MAVLink command: its number, or its name with or without `MAV_CMD_`. */
        CommandChoice: number | string;
        /** @description A value of an enumerated parameter. */
        CommandChoiceInfo: {
            /**
             * Format: double
             * @description The value.
             */
            value: number;
            /** @description Its meaning. */
            word: components["schemas"]["ChoiceWord"];
        };
        /** @description A command of the table. */
        CommandInfo: {
            /** @description Category of the command. */
            category: components["schemas"]["CommandCategory"];
            /** @description Whether parameters 5 to 7 are latitude, longitude and altitude. */
            has_position: boolean;
            /** @description Whether a plane flies to that position. */
            is_destination: boolean;
            /** @description Name without `MAV_CMD_`. */
            name: string;
            /**
             * Format: int32
             * @description `MAV_CMD` number.
             */
            number: number;
            /** @description Parameters 1 to 7. */
            params: [
                components["schemas"]["CommandParam"],
                components["schemas"]["CommandParam"],
                components["schemas"]["CommandParam"],
                components["schemas"]["CommandParam"],
                components["schemas"]["CommandParam"],
                components["schemas"]["CommandParam"],
                components["schemas"]["CommandParam"]
            ];
            /** @description How ArduPlane handles it. */
            support: components["schemas"]["CommandSupport"];
            /** @description Display name in English. */
            title: string;
        };
        /** @description One parameter of a command. */
        CommandParam: {
            /** @description Named values, when the parameter is an enumeration; empty when it is a number or its values are not known. */
            choices: components["schemas"]["CommandChoiceInfo"][];
            /**
             * Format: double
             * @description Default for a new item.
             */
            default: number | null;
            /** @description Display name in English; empty when the command does not use the parameter. */
            label: string;
            /**
             * Format: double
             * @description Largest sensible value.
             */
            max: number | null;
            /**
             * Format: double
             * @description Smallest sensible value.
             */
            min: number | null;
            /** @description Unit symbol; empty when there is none. */
            unit: string;
        };
        /**
         * @description How ArduPlane handles a command.
         * @enum {string}
         */
        CommandSupport: "flown" | "needs_vtol" | "ignored" | "list";
        /**
         * @description An item of a `.plan` that stands for several: a survey, a corridor, a landing pattern, a structure scan.
         *
         *     The mission holds the items that it stands for. It is kept beside them, and written in their place as long as they
         *     are in the mission as it made them: so QGroundControl opens it as what it was.
         */
        ComplexItem: {
            /** @description The whole of it, as JSON. */
            json: string;
            /** @description `complexItemType`: `survey`, `CorridorScan`, `fwLandingPattern`, `StructureScan`…. */
            kind: string;
        };
        /** @description Position of a complex item's items in the mission of its plan. */
        ComplexPart: {
            /** @description Number of items that it generated. */
            count: number;
            /** @description First item, counted from 1; null when its items were edited and are now ordinary items. */
            first_item: number | null;
            /** @description `survey`, `CorridorScan`, `fwLandingPattern`, `StructureScan`…. */
            kind: string;
            survey: components["schemas"]["SurveyRequest"] | null;
        };
        /** @description A conflict between two flights. */
        Conflict: {
            /**
             * Format: double
             * @description Time at which the first flight enters the conflict.
             */
            begins_s: number;
            /**
             * Format: double
             * @description Time at which the conflict ends.
             */
            ends_s: number;
            /** @description The two flights, counted from 1 in the order of the request. */
            flights: number[];
            /**
             * Format: double
             * @description Horizontal distance there.
             */
            horizontal_m: number;
            /** @description Description in English. */
            message: string;
            /** @description Positions of both flights at their smallest horizontal distance. */
            nearest: components["schemas"]["ConflictPlace"][];
            /**
             * Format: double
             * @description Vertical distance there.
             */
            vertical_m: number;
        };
        /** @description Position of a flight at a time. */
        ConflictPlace: {
            /**
             * Format: double
             * @description Altitude above mean sea level.
             */
            alt_amsl_m: number;
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
            /**
             * Format: double
             * @description Time.
             */
            time_s: number;
        };
        /** @description Corridor of flights, as lists of equal length. */
        Corridor: {
            /** @description Upper edge above home, metres. */
            high_m: number[];
            /** @description Left edge. */
            left: components["schemas"]["LatLon"][];
            /** @description Lower edge above home, metres. */
            low_m: number[];
            /** @description Right edge. */
            right: components["schemas"]["LatLon"][];
            /** @description Time in the expected flight, seconds, ascending. */
            time_s: number[];
        };
        /** @description Items with converted altitudes. */
        CountedItems: {
            /** @description The items. */
            items: components["schemas"]["PlanItem"][];
            /** @description Items that were not converted: their altitude value is unchanged, since a reference level is unknown. */
            unconverted: components["schemas"]["Unconverted"][];
        };
        /**
         * @description Kind of a limit that was exceeded.
         * @enum {string}
         */
        Crowd: "sessions" | "sockets" | "viewers" | "operations" | "requests" | "links" | "subscriptions" | "bodies" | "replays" | "vehicles";
        /** @description A decision of a vehicle. */
        Decision: {
            /** @description Reaction. */
            reaction: components["schemas"]["Reaction"];
            /**
             * Format: double
             * @description Time, seconds since the beginning of the rehearsed flight.
             */
            time_s: number;
        };
        /** @description The request for control that is declined. */
        DeclinedRequest: {
            /**
             * @description Name of the operator whose request is declined, as the session's `requested_by` had it; the present one when
             *     absent.
             */
            requested_by?: string | null;
        };
        /** @description Empty answer: the vehicle accepted the request, and its telemetry shows the effect where it can be observed. */
        Done: Record<string, never>;
        /** @description How much may be otherwise than expected, as standard deviations. */
        Doubts: {
            /**
             * Format: double
             * @description Of drag, as a part of it. Default 0.1.
             * @default 0.1
             */
            drag: number;
            /**
             * Format: double
             * @description Gusts of each flight, m/s. Default 1.
             * @default 1
             */
            gust_m_s: number;
            /**
             * Format: double
             * @description Of the power that a thrust takes, as a part of it. Default 0.1.
             * @default 0.1
             */
            power: number;
            /**
             * Format: double
             * @description Of thrust, as a part of it. Default 0.05.
             * @default 0.05
             */
            thrust: number;
            /**
             * Format: double
             * @description Of its direction, degrees. Default 15.
             * @default 15
             */
            wind_from_deg: number;
            /**
             * Format: double
             * @description Of the wind's speed, m/s. Default 1.5.
             * @default 1.5
             */
            wind_speed_m_s: number;
        };
        /** @description EKF_STATUS_REPORT: agreement of the estimator with its sensors; a test ratio of 1 is the limit. */
        Ekf: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Test ratio of the compass.
             */
            compass_variance: number | null;
            /**
             * Format: int32
             * @description `EKF_STATUS_FLAGS` bits.
             */
            flags: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Test ratio of horizontal position.
             */
            pos_horiz_variance: number | null;
            /**
             * Format: double
             * @description Test ratio of altitude.
             */
            pos_vert_variance: number | null;
            /**
             * Format: double
             * @description Test ratio of terrain altitude.
             */
            terrain_alt_variance: number | null;
            /**
             * Format: double
             * @description Test ratio of velocity.
             */
            velocity_variance: number | null;
        };
        /** @description Height of the ground at a place, as far as it is known. */
        ElevationPoint: {
            /**
             * Format: double
             * @description Height of the ground above mean sea level; null: unknown.
             */
            alt_amsl_m: number | null;
            /** @description Datum of the heights: the geoid model of mean sea level. */
            datum: string | null;
            /**
             * Format: double
             * @description How far apart heights are in that source.
             */
            resolution_m: number | null;
            /** @description Id of the source that it comes from. */
            source: string | null;
        };
        /** @description The ground under a line. */
        ElevationProfile: {
            /** @description Datum of the heights. */
            datum: string | null;
            /** @description Why a source failed. */
            error: string | null;
            /**
             * Format: double
             * @description Of the line.
             */
            length_m: number;
            /**
             * Format: double
             * @description The highest ground that is known.
             */
            max_alt_amsl_m: number | null;
            /** @description Evenly between the line's points, which are all among them. */
            samples: components["schemas"]["ElevationProfileSample"][];
            /** @description Ids of the sources that heights come from. */
            sources: string[];
            /**
             * Format: int32
             * @description Samples without a height.
             */
            unknown: number;
        };
        /** @description A place of a profile. */
        ElevationProfileSample: {
            /**
             * Format: double
             * @description Height of the ground above mean sea level; null: unknown.
             */
            alt_amsl_m: number | null;
            /**
             * Format: double
             * @description Along the line.
             */
            distance_m: number;
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
        };
        /** @description Positions whose ground elevations are wanted. */
        ElevationRequest: {
            /** @description Positions. */
            points: components["schemas"]["LatLon"][];
        };
        /** @description Ground elevations of positions. */
        Elevations: {
            /** @description Why a source failed; null when none did. */
            error: string | null;
            /** @description Elevations in the order of the request. */
            points: components["schemas"]["ElevationPoint"][];
        };
        /**
         * @description How a rehearsed flight ends.
         * @enum {string}
         */
        Ending: "landed" | "returned" | "unlimited" | "endless" | "ground" | "held" | "grounded" | "not-rehearsed" | "too-long";
        /** @description Number of flights with one ending. */
        EndingCount: {
            /** @description Number of flights. */
            count: number;
            /** @description The ending. */
            ending: components["schemas"]["Ending"];
        };
        /** @description EFI_STATUS: an engine with fuel injection. Values that are not measured may be reported as 0. */
        Engine: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Atmospheric pressure.
             */
            barometric_pa: number | null;
            /**
             * Format: double
             * @description Temperature of the cylinder head.
             */
            cylinder_head_temperature_c: number | null;
            /**
             * Format: double
             * @description Number of the engine control unit.
             */
            ecu_index: number | null;
            /**
             * Format: double
             * @description Temperature of the exhaust gas.
             */
            exhaust_gas_temperature_c: number | null;
            /**
             * Format: double
             * @description Fuel used.
             */
            fuel_consumed_cm3: number | null;
            /**
             * Format: double
             * @description Fuel flow, cubic centimetres per minute.
             */
            fuel_flow_cm3_min: number | null;
            /**
             * Format: double
             * @description Fuel pressure.
             */
            fuel_pressure_pa: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: int32
             * @description Health as sent: 1 healthy and 0 not on ArduPilot; 0 stopped, 1 starting, 2 running and 3 at fault on PX4.
             */
            health: number;
            /**
             * Format: double
             * @description Ignition timing, crank angle.
             */
            ignition_timing_deg: number | null;
            /**
             * Format: double
             * @description Ignition voltage.
             */
            ignition_v: number | null;
            /**
             * Format: double
             * @description Injection time.
             */
            injection_ms: number | null;
            /**
             * Format: double
             * @description Pressure in the intake manifold.
             */
            intake_manifold_pa: number | null;
            /**
             * Format: double
             * @description Temperature in the intake manifold.
             */
            intake_manifold_temperature_c: number | null;
            /**
             * Format: double
             * @description Load, 0 to 200 %.
             */
            load_pct: number | null;
            /**
             * Format: double
             * @description Correction factor of the fuel for pressure and temperature.
             */
            pressure_temperature_compensation: number | null;
            /**
             * Format: double
             * @description Revolutions per minute.
             */
            rpm: number | null;
            /**
             * Format: double
             * @description Charging time of the ignition coil.
             */
            spark_dwell_ms: number | null;
            /**
             * Format: double
             * @description Commanded throttle, 0 to 100 %.
             */
            throttle_output_pct: number | null;
            /**
             * Format: double
             * @description Throttle position, 0 to 100 %.
             */
            throttle_position_pct: number | null;
        };
        /** @description A detail of an event. */
        EventDetail: string | number;
        /** @description The part of a rehearsed track that shows whether a flight is late or low, as lists of equal length. */
        ExpectedTrack: {
            /** @description Altitude above home, metres. */
            height_m: number[];
            /** @description Current item, counted from 1; null during a return and after the landing. */
            item: (number | null)[];
            /** @description Latitude, degrees. */
            lat_deg: number[];
            /** @description Longitude, degrees. */
            lon_deg: number[];
            /** @description Time since its beginning, seconds, ascending. */
            time_s: number[];
        };
        /** @description EXTENDED_SYS_STATE: on the ground or in the air. */
        ExtendedState: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description `"undefined"`, `"on ground"`, `"in air"`, `"taking off"` or `"landing"`. */
            landed: string;
            /**
             * Format: int32
             * @description `MAV_VTOL_STATE` (3 multicopter, 4 fixed wing, 1 and 2 transitions); null for a plane without VTOL.
             */
            vtol: number | null;
        };
        /** @description A geofence. */
        Fence: {
            return_point: components["schemas"]["ReturnPoint"] | null;
            /** @description Zones. All of them apply, unless the vehicle takes the union of its inclusion zones (`FENCE_OPTIONS`, bit 1). */
            zones: components["schemas"]["FenceZone"][];
        };
        /**
         * @description What is wrong with a fence.
         * @enum {string}
         */
        FenceFault: "too-few-corners" | "too-many-corners" | "radius" | "return-height" | "return-place";
        /** @description FENCE_STATUS. */
        FenceStatus: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: int32
             * @description Breaches so far.
             */
            breach_count: number;
            /**
             * Format: int32
             * @description Kind of the last breach (`FENCE_BREACH`: 1 too low, 2 too high, 3 over the boundary).
             */
            breach_type: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description Whether the vehicle is outside now. */
            is_breached: boolean;
        };
        /** @description One zone of a fence. */
        FenceZone: {
            /** @description True: the vehicle must stay inside; false: it must stay outside. */
            inclusion: boolean;
            /** @description Corners of a polygon, or the centre of a circle. */
            points: components["schemas"]["LatLon"][];
            /**
             * Format: double
             * @description Radius of a circle; null for a polygon.
             */
            radius_m: number | null;
            /** @description Shape of the zone. */
            shape: components["schemas"]["ZoneShape"];
        };
        /** @description One parameter of a parameter file. */
        FileParam: {
            /** @description Name: up to 16 capital letters, digits and underscores. */
            name: string;
            /**
             * Format: double
             * @description Value.
             */
            value: number;
        };
        /**
         * @description Something wrong or doubtful in a plan. `message` and `remedy` say it in English; `code` and `figures` say the same
         *     to programs.
         */
        Finding: components["schemas"]["FindingKind"] & {
            /**
             * @description The item, counted from 1 as its seq on ArduPilot; null when it is about the whole plan, home, the fence or rally
             *     points.
             */
            item: number | null;
            /** @description The fault. */
            message: string;
            /** @description How to fix it. */
            remedy: string;
            /** @description How bad it is. */
            severity: components["schemas"]["FindingSeverity"];
        };
        /**
         * @description A finding and a change that resolves it. With `items` in place of the replaced ones, the finding disappears and no
         *     new error appears.
         */
        FindingFix: components["schemas"]["FixKind"] & {
            /** @description Number of replaced items; 0 when the new items are inserted before `first_item`. */
            count: number;
            /** @description The finding. */
            finding: components["schemas"]["Finding"];
            /** @description First replaced item, counted from 1; one past the last item when the new items are appended. */
            first_item: number;
            /**
             * @description New items. The plan's jumps to items after the replaced ones keep their destinations, so their numbers must be
             *     adapted.
             */
            items: components["schemas"]["PlanItem"][];
            /** @description Description of the change, in English. */
            message: string;
        };
        /** @description Kind of finding, with its figures. `code` is stable; a figure's name ends in its unit. */
        FindingKind: {
            /** @enum {string} */
            code: "empty-mission";
            /** @description There is nothing to fly. */
            figures: {
                /** @description Whether the plan has a fence or rally points. */
                has_areas: boolean;
            };
        } | {
            /** @enum {string} */
            code: "too-many-items";
            /** @description More items than the vehicle holds. */
            figures: {
                /** @description Items, home not counted. */
                count: number;
                /** @description How many it holds. */
                max: number;
            };
        } | {
            /** @enum {string} */
            code: "bad-value";
            /** @description A value that is not finite, off the globe, or in a frame without meaning. */
            figures: {
                /** @description Which: `param1` … `param4`, `x`, `y`, `z`, `frame`. */
                field: string;
                /**
                 * Format: double
                 * @description The value; null when it is not a number.
                 */
                value: number | null;
                /** @description The requirement that it violates. */
                wanted: components["schemas"]["WantedValue"];
            };
        } | {
            /** @enum {string} */
            code: "unsupported-command";
            /** @description A command that ArduPlane refuses. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "ignored-command";
            /** @description A command that the vehicle stores and skips. */
            figures: {
                /** @description Whether a plane that can hover would do it. */
                needs_hover: boolean;
            };
        } | {
            /** @enum {string} */
            code: "param-out-of-range";
            /** @description A parameter outside its range. */
            figures: {
                /** @description English name of the parameter. */
                label: string;
                /**
                 * Format: double
                 * @description Most; null without one.
                 */
                max: number | null;
                /**
                 * Format: double
                 * @description Least; null without one.
                 */
                min: number | null;
                /** @description Which, 1 to 7. */
                param: number;
                /** @description Symbol of the unit; empty when there is none. */
                unit: string;
                /**
                 * Format: double
                 * @description Its value.
                 */
                value: number;
            };
        } | {
            /** @enum {string} */
            code: "param-changed";
            /** @description A parameter that ArduPlane keeps as another value. */
            figures: {
                /** @description Whether the vehicle does not use the parameter at all. */
                is_unused: boolean;
                /**
                 * Format: double
                 * @description The value that the vehicle stores.
                 */
                kept: number;
                /** @description English name of the parameter. */
                label: string;
                /** @description Which, 1 to 7. */
                param: number;
                /** @description Symbol of the unit; empty when there is none. */
                unit: string;
                /**
                 * Format: double
                 * @description Its value.
                 */
                value: number;
            };
        } | {
            /** @enum {string} */
            code: "speed-not-taken";
            /** @description An airspeed outside the limits of the vehicle, which keeps the one it has. */
            figures: {
                /**
                 * Format: double
                 * @description The highest that it takes; null when it is not known.
                 */
                max_m_s: number | null;
                /**
                 * Format: double
                 * @description The lowest that it takes; null when it is not known.
                 */
                min_m_s: number | null;
                /**
                 * Format: double
                 * @description The airspeed.
                 */
                speed_m_s: number;
            };
        } | {
            /** @enum {string} */
            code: "missing-position";
            /** @description A place without latitude, longitude or height. */
            figures: {
                /** @description The part that is missing. */
                missing: components["schemas"]["MissingPart"];
            };
        } | {
            /** @enum {string} */
            code: "zero-coordinates";
            /** @description Latitude and longitude both 0. */
            figures: {
                /** @description Whether the vehicle does it where it is then. */
                is_here: boolean;
            };
        } | {
            /** @enum {string} */
            code: "no-takeoff";
            /** @description On the ground, and the mission does not begin with a take-off. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "takeoff-too-low";
            /** @description A take-off to a height that is not above home. */
            figures: {
                /**
                 * Format: double
                 * @description Height that it climbs to.
                 */
                alt_m: number;
                datum: components["schemas"]["HeightDatum"] | null;
            };
        } | {
            /** @enum {string} */
            code: "no-landing";
            /** @description The mission ends without landing or return. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "items-after-landing";
            /** @description Items after a landing. */
            figures: {
                /** @description The first that is not flown, counted from 1. */
                next_item: number;
            };
        } | {
            /** @enum {string} */
            code: "endless-loiter";
            /** @description A circle without end, and items after it. */
            figures: {
                /** @description The first that is not flown, counted from 1. */
                next_item: number;
            };
        } | {
            /** @enum {string} */
            code: "land-start-without-landing";
            /** @description A start of a landing sequence without landing. */
            figures: {
                /** @description Whether there is a landing, and it lacks its approach. */
                has_landing: boolean;
            };
        } | {
            /** @enum {string} */
            code: "land-start-disabled";
            /** @description A DO_LAND_START for a vehicle whose `RTL_AUTOLAND` is 0, which refuses to arm with it. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "jump-target";
            /** @description A jump to nowhere. */
            figures: {
                /** @description The last item there is. */
                last: number;
                /**
                 * Format: double
                 * @description The item or tag that it names.
                 */
                target: number;
            };
        } | {
            /** @enum {string} */
            code: "endless-jump";
            /** @description A jump that repeats for ever. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "idle-jump";
            /** @description A jump that runs in a circle without flying. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "too-many-jumps";
            /** @description More jumps than the vehicle tracks. */
            figures: {
                /** @description Jumps. */
                count: number;
                /** @description How many small boards track. */
                max: number;
            };
        } | {
            /** @enum {string} */
            code: "far-from-home";
            /** @description Far from home. */
            figures: {
                /**
                 * Format: double
                 * @description How far.
                 */
                distance_m: number;
                /**
                 * Format: double
                 * @description The limit.
                 */
                far_m: number;
            };
        } | {
            /** @enum {string} */
            code: "out-of-reach";
            /** @description Farther from home and from the plane than it flies. */
            figures: {
                /**
                 * Format: double
                 * @description To home or the plane, whichever is nearer.
                 */
                distance_m: number;
                /** @description Whether the place is in reach with latitude and longitude swapped. */
                is_swapped: boolean;
                /**
                 * Format: double
                 * @description The limit.
                 */
                reach_m: number;
            };
        } | {
            /** @enum {string} */
            code: "area-out-of-reach";
            /**
             * @description A rally point, zone or return point that is as far away: nearly always one with its coordinates confused, and then
             *     nothing is where it is wanted.
             */
            figures: {
                /**
                 * Format: double
                 * @description To home or the plane, whichever is nearer; of a zone to its edge.
                 */
                distance_m: number;
                /** @description The zone of the fence, counted from 1; null, as the rally point, for the fence's return point. */
                fence_zone: number | null;
                /** @description Whether it is in reach with latitude and longitude swapped. */
                is_swapped: boolean;
                /** @description The rally point, counted from 1. */
                rally_point: number | null;
                /**
                 * Format: double
                 * @description The limit.
                 */
                reach_m: number;
            };
        } | {
            /** @enum {string} */
            code: "far-first";
            /** @description The first destination is far from the plane. */
            figures: {
                /**
                 * Format: double
                 * @description How far.
                 */
                distance_m: number;
            };
        } | {
            /** @enum {string} */
            code: "below-home";
            /** @description At or below the height of home, or of the ground. */
            figures: {
                /**
                 * Format: double
                 * @description Its height.
                 */
                alt_m: number;
                datum: components["schemas"]["HeightDatum"] | null;
            };
        } | {
            /** @enum {string} */
            code: "landing-off-field";
            /** @description A landing on the field of home, at another height than the field's. */
            figures: {
                /** @description Whether it lies under it, so far. */
                is_under: boolean;
                /**
                 * Format: double
                 * @description How far its point lies above the field.
                 */
                off_m: number;
            };
        } | {
            /** @enum {string} */
            code: "short-leg";
            /** @description A leg shorter than the plane can turn. */
            figures: {
                /**
                 * Format: double
                 * @description Length of the leg.
                 */
                length_m: number;
                /**
                 * Format: double
                 * @description Radius of a turn.
                 */
                turn_radius_m: number;
            };
        } | {
            /** @enum {string} */
            code: "steep-approach";
            /** @description A final approach that is steep. */
            figures: {
                /**
                 * Format: double
                 * @description Height lost.
                 */
                drop_m: number;
                /**
                 * Format: double
                 * @description Length of the approach.
                 */
                length_m: number;
                /**
                 * Format: double
                 * @description Length from which it would not be steep.
                 */
                wanted_length_m: number;
            };
        } | {
            /** @enum {string} */
            code: "flat-approach";
            /** @description A final approach that does not descend. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "outside-fence";
            /** @description Outside the fence. */
            figures: {
                /** @description Whether that is a zone to stay in. */
                is_inclusion: boolean;
                /** @description The rally point, counted from 1; null when it is an item, or home. */
                rally_point: number | null;
                /** @description The zone that forbids it, counted from 1. */
                zone: number;
            };
        } | {
            /** @enum {string} */
            code: "return-point-outside-fence";
            /** @description The return point of the fence is outside the fence. */
            figures: {
                /** @description Whether that is a zone to stay in. */
                is_inclusion: boolean;
                /** @description The zone that forbids it, counted from 1. */
                zone: number;
            };
        } | {
            /** @enum {string} */
            code: "leg-crosses-fence";
            /** @description A leg that crosses the fence. */
            figures: {
                /** @description The zone, counted from 1. */
                zone: number;
            };
        } | {
            /** @enum {string} */
            code: "flies-into-ground";
            /** @description Rehearsed: the plane comes down before it lands. */
            figures: {
                /**
                 * Format: double
                 * @description Where, degrees.
                 */
                lat_deg: number;
                /**
                 * Format: double
                 * @description Where, degrees.
                 */
                lon_deg: number;
            };
        } | {
            /** @enum {string} */
            code: "near-ground";
            /** @description Rehearsed: the plane comes near the ground. */
            figures: {
                /**
                 * Format: double
                 * @description How near, at the worst place.
                 */
                clearance_m: number;
                /**
                 * Format: double
                 * @description Where, degrees.
                 */
                lat_deg: number;
                /**
                 * Format: double
                 * @description Where, degrees.
                 */
                lon_deg: number;
                /**
                 * Format: double
                 * @description The clearance required there.
                 */
                wanted_m: number;
            };
        } | {
            /** @enum {string} */
            code: "ground-not-known";
            /** @description Rehearsed: a height counts from the ground, which is not known. */
            figures: {
                /**
                 * Format: double
                 * @description Its height above that ground; null without one.
                 */
                alt_m: number | null;
                /** @description Whether the vehicle's terrain data are switched off (`TERRAIN_ENABLE` 0). */
                is_off: boolean;
            };
        } | {
            /** @enum {string} */
            code: "home-off-ground";
            /** @description Rehearsed: home's height is not that of the ground there. */
            figures: {
                /**
                 * Format: double
                 * @description How far it is off.
                 */
                difference_m: number;
                /** @description Whether it lies above the ground. */
                is_above: boolean;
            };
        } | {
            /** @enum {string} */
            code: "held-by-wind";
            /** @description Rehearsed: the wind does not let the plane come nearer. */
            figures: {
                /**
                 * Format: double
                 * @description The wind.
                 */
                wind_m_s: number;
            };
        } | {
            /** @enum {string} */
            code: "waypoint-missed";
            /** @description Rehearsed: the plane flies by and does not come near. */
            figures: {
                /**
                 * Format: double
                 * @description How near it comes.
                 */
                distance_m: number;
            };
        } | {
            /** @enum {string} */
            code: "height-not-reached";
            /** @description Rehearsed: the plane is not yet at the height that it should have there. */
            figures: {
                /**
                 * Format: double
                 * @description How far it is off.
                 */
                difference_m: number;
                /** @description Whether it is too low. */
                is_low: boolean;
            };
        } | {
            /** @enum {string} */
            code: "leaves-fence";
            /** @description Rehearsed: the plane leaves the fence on its way. */
            figures: {
                /** @description The zone, counted from 1. */
                zone: number;
            };
        } | {
            /** @enum {string} */
            code: "return-hits-ground";
            /** @description Rehearsed: a return that is asked for on the way there ends in the ground. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "return-held-by-wind";
            /** @description Rehearsed: the wind does not let the plane come back from there. */
            figures: {
                /**
                 * Format: double
                 * @description The wind.
                 */
                wind_m_s: number;
            };
        } | {
            /** @enum {string} */
            code: "return-leaves-fence";
            /** @description Rehearsed: a return that is asked for on the way there leaves the fence. */
            figures: {
                /** @description The zone, counted from 1. */
                zone: number;
            };
        } | {
            /** @enum {string} */
            code: "go-around-hits-ground";
            /** @description Rehearsed: a landing that is broken off ends in the ground. */
            figures: Record<string, never>;
        } | {
            /** @enum {string} */
            code: "lands-off";
            /** @description Rehearsed: the plane touches the ground far from its landing point. */
            figures: {
                /**
                 * Format: double
                 * @description How far.
                 */
                distance_m: number;
                /** @description Whether that is beyond it. */
                is_long: boolean;
            };
        } | {
            /** @enum {string} */
            code: "lands-downwind";
            /** @description Rehearsed: the wind comes from behind at the touch-down. */
            figures: {
                /**
                 * Format: double
                 * @description Its part from behind.
                 */
                tailwind_m_s: number;
            };
        } | {
            /** @enum {string} */
            code: "battery-below-reserve";
            /** @description Rehearsed: less of the battery is left at the end than should be. */
            figures: {
                /**
                 * Format: double
                 * @description Remaining charge, % of its capacity.
                 */
                left_pct: number;
                /**
                 * Format: double
                 * @description What should be.
                 */
                reserve_pct: number;
            };
        } | {
            /** @enum {string} */
            code: "battery-empty";
            /** @description Rehearsed: the battery is empty before the end. */
            figures: {
                /**
                 * Format: double
                 * @description Energy that the flight needs beyond what the battery holds.
                 */
                lacks_wh: number;
                /**
                 * Format: double
                 * @description When, since the start.
                 */
                time_s: number;
            };
        } | {
            /** @enum {string} */
            code: "bad-fence";
            /** @description A fence that every vehicle would refuse. */
            figures: {
                /**
                 * Format: double
                 * @description Height of the return point, above home.
                 */
                alt_rel_home_m: number | null;
                /** @description Corners of the polygon. */
                corners: number | null;
                /** @description The fault. */
                fault: components["schemas"]["FenceFault"];
                /**
                 * Format: double
                 * @description Radius of the circle, or null.
                 */
                radius_m: number | null;
                /** @description The zone, counted from 1; null for the return point. */
                zone: number | null;
            };
        } | {
            /** @enum {string} */
            code: "bad-rally";
            /** @description A rally point that every vehicle would refuse, or that is badly placed. */
            figures: {
                /**
                 * Format: double
                 * @description Its height in its frame; null when it is not a number.
                 */
                alt_m: number | null;
                /** @description The fault. */
                fault: components["schemas"]["RallyFault"];
                /** @description The rally point, counted from 1. */
                rally_point: number;
            };
        } | {
            /** @enum {string} */
            code: "survey-line-missed";
            /** @description Rehearsed: a line of a survey is not flown, or flown so far aside that no overlap remains. */
            figures: {
                /**
                 * Format: double
                 * @description How far aside; null when it is not flown.
                 */
                distance_m: number | null;
                /** @description The line, counted from 1 in the order flown. */
                line: number;
            };
        } | {
            /** @enum {string} */
            code: "survey-holes";
            /** @description Rehearsed: ground that no picture of a survey shows. */
            figures: {
                /** @description How many places. */
                holes: number;
                /**
                 * Format: double
                 * @description Side of a square as large as the largest.
                 */
                side_m: number;
            };
        };
        /**
         * @description How bad a finding is.
         * @enum {string}
         */
        FindingSeverity: "error" | "warning";
        /** @description Kind of fix, with its figures. `code` is stable; a figure's name ends in its unit. */
        FixKind: {
            /** @enum {string} */
            does: "set-param";
            /** @description Sets a parameter of the item. */
            with: {
                /** @description English name of the parameter. */
                label: string;
                /** @description Symbol of the unit; empty when there is none. */
                unit: string;
                /**
                 * Format: double
                 * @description Its value.
                 */
                value: number;
            };
        } | {
            /** @enum {string} */
            does: "delete-item";
            /** @description Deletes the item. */
            with: Record<string, never>;
        } | {
            /** @enum {string} */
            does: "add-takeoff";
            /** @description Puts a take-off first. */
            with: {
                /**
                 * Format: double
                 * @description Height that it climbs to, above home.
                 */
                alt_m: number;
            };
        } | {
            /** @enum {string} */
            does: "raise-takeoff";
            /** @description Climbs to another height. */
            with: {
                /**
                 * Format: double
                 * @description Height that it climbs to, above home.
                 */
                alt_m: number;
            };
        } | {
            /** @enum {string} */
            does: "add-landing";
            /** @description Ends the mission with a landing at home. */
            with: {
                /**
                 * Format: double
                 * @description Course of its final leg.
                 */
                course_deg: number;
            };
        } | {
            /** @enum {string} */
            does: "turn-landing";
            /** @description Lays the landing out again at the same point. */
            with: {
                /**
                 * Format: double
                 * @description Course of its final leg.
                 */
                course_deg: number;
            };
        } | {
            /** @enum {string} */
            does: "add-circle";
            /** @description Climbs or sinks in a circle before the item. */
            with: {
                /**
                 * Format: double
                 * @description Height that it is left at, as the item's counts.
                 */
                alt_m: number;
            };
        } | {
            /** @enum {string} */
            does: "raise";
            /** @description Raises the item, and the one before. */
            with: {
                /**
                 * Format: double
                 * @description By how much.
                 */
                difference_m: number;
            };
        } | {
            /** @enum {string} */
            does: "move-away";
            /** @description Moves the item away from the one before. */
            with: {
                /**
                 * Format: double
                 * @description By how much.
                 */
                distance_m: number;
            };
        } | {
            /** @enum {string} */
            does: "set-parameter";
            /** @description Sets a parameter of the vehicle. The items stay. */
            with: {
                /** @description Its name. */
                name: string;
                /**
                 * Format: double
                 * @description Its value.
                 */
                value: number;
            };
        };
        /** @description The network of a fleet, over which remote vehicles are heard. */
        FleetNetwork: {
            /** @description Name of the fleet. */
            name: string;
            /** @description Why its vehicles are not heard here, in English; null while all is well. */
            problem: string | null;
        };
        /** @description Time of a flight on the vehicle's own clock, which runs faster in some simulators. */
        FlightNow: {
            /**
             * Format: double
             * @description Remaining charge of its battery; null when unknown.
             */
            battery_pct: number | null;
            /**
             * Format: double
             * @description Time since the vehicle booted; null when unknown.
             */
            boot_s: number | null;
        };
        /**
         * @description Flight characteristics according to an ArduPlane's parameters, which the station reads by itself; null where not
         *     read.
         */
        FlightParameters: {
            /**
             * Format: double
             * @description Airspeed in automatic flight (`AIRSPEED_CRUISE`, before 4.5 `TRIM_ARSPD_CM`).
             */
            airspeed_m_s: number | null;
            /**
             * @description Whether a return uses the mission's landing (`RTL_AUTOLAND` is not 0); otherwise the vehicle refuses to arm with
             *     a `DO_LAND_START`.
             */
            finds_landing: boolean | null;
            /**
             * Format: double
             * @description Radius of circles without a radius of their own (`WP_LOITER_RAD`).
             */
            loiter_radius_m: number | null;
        };
        /** @description Steps needed before a flight, which `POST /vehicles/{id}/prepare-flight` carries out. */
        FlightPreparation: {
            /** @description Present mode. */
            from_mode: string;
            /** @description Mode to change to; null when it arms in the present one. */
            mode: string | null;
            /** @description Whether the mission is reset to its beginning; false when there is none. */
            rewinds_mission: boolean;
        };
        /** @description A survey line as flown. */
        FlownLine: {
            /** @description Whether it is not flown, or so far off that no overlap with the next line remains. */
            is_missed: boolean;
            /**
             * Format: double
             * @description Largest distance from the line while images are taken; null when it is not flown.
             */
            off_m: number | null;
            /**
             * Format: int64
             * @description Number of images on it.
             */
            photos: number;
        };
        /** @description Coverage by the images of a survey flown as rehearsed. */
        FlownSurvey: {
            /**
             * Format: double
             * @description Fraction of the area that at least one image covers, 0 to 1; null without a camera.
             */
            covered: number | null;
            /**
             * Format: double
             * @description Duration.
             */
            duration_s: number;
            /** @description Errors and doubts found. */
            findings: components["schemas"]["Finding"][];
            /**
             * @description Ground corners of each image, in order around it; null for an image that includes the horizon, and without a
             *     camera.
             */
            footprints: (components["schemas"]["LatLon"][] | null)[];
            /** @description Largest uncovered places, at most 20. */
            holes: components["schemas"]["SurveyHole"][];
            /** @description Whether the plane's own parameters were known; otherwise a default ArduPlane is assumed. */
            knows_parameters: boolean;
            /** @description Lines as flown, in the order of `lines`. */
            lines: components["schemas"]["FlownLine"][];
            /**
             * Format: double
             * @description Fraction of the area covered by as many images as the overlap promises, 0 to 1; null without a camera.
             */
            overlapped: number | null;
            /** @description Position of the plane at each image. */
            photos: components["schemas"]["LatLon"][];
            /**
             * Format: int64
             * @description That number of images.
             */
            views_promised: number;
        };
        /** @description A camera recording or image on the server's disk. */
        Footage: {
            /**
             * Format: int64
             * @description Start of the recording, or time of capture, to the second: seconds since 1970, UTC.
             */
            begin_unix_s: number;
            /**
             * Format: int64
             * @description File size.
             */
            bytes: number;
            /** @description Name of the camera. */
            camera: string;
            /**
             * Format: double
             * @description Duration of a recording; null for images, while it is being recorded, and when it was not closed properly.
             */
            duration_s: number | null;
            /** @description Whether it is being recorded. */
            is_current: boolean;
            /** @description Kind of the file. */
            kind: components["schemas"]["FootageKind"];
            /** @description File name. */
            name: string;
        };
        /**
         * @description Kind of a footage file.
         * @enum {string}
         */
        FootageKind: "video" | "picture";
        /** @description Items whose altitudes are to be converted to another frame. */
        FrameChange: {
            /** @description New frame. */
            frame: components["schemas"]["AltFrame"];
            /** @description The items, and their home; when it has none, the vehicle's home is used. The rest of the plan is ignored. */
            plan: components["schemas"]["Plan"];
            /**
             * Format: int32
             * @description Vehicle that is to fly them.
             */
            vehicle?: number | null;
        };
        /** @description GPS_RAW_INT: the GPS receiver's data, unfiltered. */
        Gps: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Altitude above mean sea level.
             */
            alt_amsl_m: number | null;
            /**
             * Format: double
             * @description Altitude above the WGS-84 ellipsoid, if the receiver reports it.
             */
            alt_ellipsoid_m: number | null;
            /**
             * Format: double
             * @description Course over ground, 0 to 360.
             */
            course_deg: number | null;
            /**
             * Format: int32
             * @description `GPS_FIX_TYPE`; 3 and more is a position in three dimensions.
             */
            fix: number;
            /** @description The fix in words. */
            fix_name: string;
            /**
             * Format: double
             * @description Speed over ground.
             */
            groundspeed_m_s: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Horizontal dilution of precision.
             */
            hdop: number | null;
            /**
             * Format: double
             * @description Horizontal uncertainty, one sigma as the receiver estimates it.
             */
            horizontal_accuracy_m: number | null;
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number | null;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number | null;
            /**
             * Format: int32
             * @description Satellites in view.
             */
            satellites: number | null;
            /**
             * Format: double
             * @description Vertical dilution of precision.
             */
            vdop: number | null;
            /**
             * Format: double
             * @description Vertical uncertainty, one sigma as the receiver estimates it.
             */
            vertical_accuracy_m: number | null;
        };
        /** @description HEARTBEAT of the autopilot: type, mode and state of the vehicle. */
        Heartbeat: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: int32
             * @description `MAV_AUTOPILOT`: 3 ArduPilot, 12 PX4.
             */
            autopilot: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description Whether the motors can run. */
            is_armed: boolean;
            /**
             * Format: int32
             * @description `MAV_TYPE`: 1 fixed wing, 2 quadrotor, 19 to 25 VTOL.
             */
            mav_type: number;
            /** @description Flight mode by name, such as `"AUTO"`; `"mode 42"` when the number is not known. */
            mode: string;
            /**
             * Format: int32
             * @description The mode's number on the wire, in the autopilot's own numbering.
             */
            mode_number: number;
            /** @description `MAV_STATE` in words, such as `"standby"` or `"active"`. */
            system_status: string;
        };
        /**
         * @description What a height counts from.
         * @enum {string}
         */
        HeightDatum: "amsl" | "home" | "terrain";
        /** @description A history file (MCAP). */
        HistoryFile: {
            /**
             * Format: int64
             * @description File size.
             */
            bytes: number;
            /**
             * Format: double
             * @description Time of the last change, seconds since 1970; null when the file system does not provide it.
             */
            modified_unix_s: number | null;
            /** @description File name. */
            name: string;
        };
        /** @description A range of records that is missing in a history. */
        HistoryGap: {
            /** @description Boot of the onboard computer: 16 hexadecimal digits. */
            boot: string;
            /**
             * Format: int64
             * @description First missing number.
             */
            first: number;
            /** @description Whether the aircraft no longer has them either; otherwise they are fetched when it is connected. */
            is_lost: boolean;
            /**
             * Format: int64
             * @description Last missing number.
             */
            last: number;
            /** @description `state`, `event` or `audit`. */
            stream: string;
        };
        /** @description Where heights relative to home are counted from. */
        Home: {
            /**
             * Format: double
             * @description Height above mean sea level, metres.
             */
            alt_amsl_m: number;
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
        };
        /** @description Where heights relative to home are counted from. */
        HomePosition: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Height above mean sea level, metres.
             */
            alt_amsl_m: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
        };
        /** @description VFR_HUD: speeds, heading and altitude for a head-up display. */
        Hud: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Airspeed (indicated or equivalent, depending on the autopilot).
             */
            airspeed_m_s: number | null;
            /**
             * Format: double
             * @description Altitude above mean sea level.
             */
            alt_amsl_m: number | null;
            /**
             * Format: double
             * @description Climb rate, up positive.
             */
            climb_m_s: number | null;
            /**
             * Format: double
             * @description Speed over ground.
             */
            groundspeed_m_s: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Heading, 0 to 360.
             */
            heading_deg: number | null;
            /**
             * Format: double
             * @description Throttle, 0 to 100 %.
             */
            throttle_pct: number | null;
        };
        /** @description SCALED_IMU to SCALED_IMU3, or an ArduPilot's RAW_IMU: one inertial sensor, body forward, right, down. */
        Imu: {
            /** @description Specific force in g (9.80665 m/s²). */
            acc_g: number[] | null;
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /** @description Angular rate. */
            gyro_rad_s: number[] | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description Magnetic field; null when all three are 0, which no place on Earth has. */
            mag_gauss: number[] | null;
            /**
             * Format: double
             * @description Temperature of the sensor.
             */
            temperature_c: number | null;
        };
        /** @description The server. */
        Info: {
            /** @description Always `vencejo`. */
            name: string;
            /** @description Whether `POST /session` needs a token. */
            needs_token: boolean;
            /** @description Version of the server. */
            version: string;
        };
        /** @description Protection of a recording from deletion. */
        KeepRecording: {
            /** @description Whether to protect it. */
            is_kept: boolean;
        };
        /** @description A landing, ready to be appended to a mission. */
        Landing: {
            /** @description Cautions for the pilot. */
            cautions: components["schemas"]["LandingCaution"][];
            /**
             * Format: double
             * @description Course of the final leg, from true north, 0 to 360.
             */
            course_deg: number;
            /** @description What determined the course. */
            direction: components["schemas"]["LandingDirection"];
            /**
             * Format: double
             * @description Length of the final leg.
             */
            final_m: number;
            /**
             * Format: double
             * @description Ground speed on the final leg; null when the wind is unknown.
             */
            groundspeed_m_s: number | null;
            /**
             * Format: double
             * @description Headwind on the final leg, negative for a tailwind; null when the wind is unknown.
             */
            headwind_m_s: number | null;
            /** @description An optional `DO_LAND_START`, `NAV_LOITER_TO_ALT`, `NAV_LAND`; altitudes above home. */
            items: components["schemas"]["PlanItem"][];
            /** @description Beginning of the final leg. */
            leaves: components["schemas"]["LatLon"];
            /**
             * Format: double
             * @description Altitude there, above home.
             */
            leaves_alt_rel_home_m: number;
            /**
             * Format: double
             * @description Radius of the circle.
             */
            radius_m: number;
            /**
             * Format: double
             * @description Slope of the final leg, height over distance.
             */
            slope: number;
        };
        /** @description One of several possible landings. */
        LandingAlternative: {
            /**
             * Format: double
             * @description Crosswind on the final leg, positive from the right; null when the wind is unknown.
             */
            crosswind_m_s: number | null;
            /**
             * Format: double
             * @description Time from the preceding position, or from home.
             */
            duration_s: number;
            /** @description How the rehearsed approach ends. */
            ending: components["schemas"]["Ending"];
            /** @description Whether its circle is clockwise, to the right of the final leg. */
            is_clockwise: boolean;
            /** @description The landing. */
            landing: components["schemas"]["Landing"];
            /** @description Reasons for and against it. */
            reasons: components["schemas"]["LandingReasonText"][];
            /**
             * Format: double
             * @description Distance of the plane's final position from the landing point, likewise.
             */
            rest_m: number | null;
            /**
             * Format: double
             * @description Distance of the touchdown from the landing point along the final leg, metres, negative before it; null when the
             *     plane does not touch down.
             */
            touch_down_m: number | null;
            /** @description Recommendation. */
            verdict: components["schemas"]["Verdict"];
        };
        /** @description A caution for the pilot before a landing is flown. */
        LandingCaution: {
            /** @description `ground-not-known`, `steep-approach`, `tailwind` or `ground-near`. */
            code: string;
            /** @description The caution in English. */
            message: string;
        };
        /**
         * @description What gave a final leg its direction.
         * @enum {string}
         */
        LandingDirection: "course" | "coming-from" | "into-wind";
        /** @description A designed landing with one part moved. */
        LandingMove: {
            /**
             * Format: double
             * @description Ground elevation above home at the landing point's new position; when absent, the point keeps its altitude.
             */
            ground_rel_home_m?: number | null;
            /**
             * @description The landing as designed: an optional `DO_LAND_START`, `NAV_LOITER_TO_ALT`, `NAV_LAND`, with altitudes above
             *     home.
             */
            items: components["schemas"]["PlanItem"][];
            /** @description Part to move. */
            part: components["schemas"]["LandingPart"];
            /** @description New position. */
            to: components["schemas"]["LatLon"];
            /**
             * Format: int32
             * @description Vehicle that is to land.
             */
            vehicle?: number | null;
            wind?: components["schemas"]["PlanWind"] | null;
        };
        /**
         * @description A part of a landing that can be moved.
         * @enum {string}
         */
        LandingPart: "point" | "final-leg" | "circle";
        /** @description What speaks for or against a landing. */
        LandingReason: {
            /** @enum {string} */
            code: "calm";
        } | {
            /** @enum {string} */
            code: "headwind";
            /**
             * Format: double
             * @description Its part along the final leg.
             */
            speed_m_s: number;
        } | {
            /** @enum {string} */
            code: "tailwind";
            /**
             * Format: double
             * @description Its part along the final leg.
             */
            speed_m_s: number;
        } | {
            /** @enum {string} */
            code: "crosswind";
            /** @description Whether it comes from the right. */
            is_from_right: boolean;
            /**
             * Format: double
             * @description Its part across the final leg.
             */
            speed_m_s: number;
        } | {
            /** @enum {string} */
            code: "steep";
            /**
             * Format: double
             * @description Height over distance.
             */
            slope: number;
        } | {
            /**
             * Format: double
             * @description How near, at the worst place; negative below the ground.
             */
            clearance_m: number;
            /** @enum {string} */
            code: "ground-near";
            /**
             * Format: double
             * @description How far from the point.
             */
            distance_m: number;
            /**
             * Format: double
             * @description The clearance required there.
             */
            wanted_m: number;
        } | {
            /** @enum {string} */
            code: "comes-to-rest";
            /**
             * Format: double
             * @description Distance from the point.
             */
            distance_m: number;
            /** @description Whether that is beyond the point. */
            is_beyond: boolean;
        } | {
            /** @enum {string} */
            code: "before-runway";
            /**
             * Format: double
             * @description By how much.
             */
            distance_m: number;
        } | {
            /** @enum {string} */
            code: "beyond-runway";
            /**
             * Format: double
             * @description By how much.
             */
            distance_m: number;
        } | {
            /** @enum {string} */
            code: "does-not-land";
            /** @description What happens. */
            ending: components["schemas"]["Ending"];
        };
        /** @description A reason for or against a landing. */
        LandingReasonText: components["schemas"]["LandingReason"] & {
            /** @description The reason in English. */
            message: string;
        };
        /**
         * @description Design request for a landing at a point or on a runway. Values that are not given come from the vehicle's
         *     parameters, as far as they were read, else from the defaults for a small plane with ArduPlane.
         */
        LandingRequest: {
            /**
             * Format: double
             * @description Approach airspeed, 5 to 60; by default the vehicle's, else 22.
             */
            airspeed_m_s?: number | null;
            at?: components["schemas"]["LatLon"] | null;
            coming_from?: components["schemas"]["LatLon"] | null;
            /**
             * Format: double
             * @description Course of the final leg, from true north; of a runway's two directions, the nearer one is used. When absent,
             *     `coming_from` gives the course, else the wind; a runway is landed on into the wind, or in calm air from its
             *     beginning.
             */
            course_deg?: number | null;
            /**
             * Format: double
             * @description Height above the ground at which the final leg begins, 15 to 200; 40 by default.
             */
            final_height_m?: number | null;
            /**
             * Format: double
             * @description Ground elevation at the landing point above home, −1000 to 1000. When absent, the maps give it, for which `home`
             *     is needed; else it is home's.
             */
            ground_rel_home_m?: number | null;
            /**
             * @description Whether `DO_LAND_START` precedes the landing; by default yes, unless the vehicle's return does not use it. An
             *     ArduPlane with `RTL_AUTOLAND` 0 refuses to arm with one.
             */
            has_land_start?: boolean | null;
            home?: components["schemas"]["LatLon"] | null;
            /**
             * @description Whether the circle is clockwise, to the right of the final leg; by default as the vehicle circles, else yes.
             *     Alternatives include both sides.
             */
            is_clockwise?: boolean | null;
            plan?: components["schemas"]["Plan"] | null;
            /**
             * Format: double
             * @description Smallest radius of the circle, 20 to 500; by default the vehicle's, else 80.
             */
            radius_m?: number | null;
            runway?: components["schemas"]["Runway"] | null;
            /**
             * Format: double
             * @description Steepest slope of the final leg, height over distance, 0.02 to 0.25; by default 0.08, or less for a vehicle with
             *     a low sink rate.
             */
            slope?: number | null;
            /**
             * Format: int32
             * @description Vehicle that is to land: airspeed, circle, slope and `DO_LAND_START` are chosen for it.
             */
            vehicle?: number | null;
            wind?: components["schemas"]["PlanWind"] | null;
        };
        /** @description A position on the ground. */
        LatLon: {
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
        };
        /** @description Model of a plane, estimated from a flight. */
        LearnedPlane: {
            /** @description Airframe. */
            airframe: components["schemas"]["Airframe"];
            /**
             * Format: double
             * @description RMS difference between measured and modelled airspeed, metres per second.
             */
            airspeed_error_m_s: number;
            /** @description Number of samples used. */
            moments: number;
            /** @description Wind of that flight. */
            wind: components["schemas"]["PlanWind"];
        };
        /**
         * @description What gave the lines their course.
         * @enum {string}
         */
        LineCourse: "asked" | "across-wind" | "along-area" | "corridor";
        /**
         * @description Why a link is not up.
         * @enum {string}
         */
        LinkFault: "address_in_use" | "not_our_address" | "no_permission" | "no_serial_permission" | "no_serial_port" | "serial_port_in_use" | "no_baud_rate" | "no_host" | "refused" | "no_answer" | "closed_by_peer" | "other";
        /** @description A link and its traffic counters. */
        LinkInfo: {
            /** @description Whether unsigned frames of vehicles that must sign are accepted on this link. */
            accepts_unsigned: boolean;
            /** @description Its link string. */
            address: string;
            /**
             * Format: double
             * @description Time since the newest frame.
             */
            age_s: number | null;
            /**
             * Format: int64
             * @description Frames with a wrong checksum.
             */
            bad_crc: number;
            /**
             * Format: int64
             * @description Bytes received.
             */
            bytes_received: number;
            /**
             * Format: int64
             * @description Bytes sent.
             */
            bytes_sent: number;
            /** @description The fault in English. */
            detail: string | null;
            fault: components["schemas"]["LinkFault"] | null;
            /** @description Whether frames are forwarded between this link and the others. */
            forward: boolean;
            /**
             * Format: int64
             * @description Frames missing according to the senders' sequence numbers.
             */
            frames_lost: number;
            /**
             * Format: double
             * @description Recent rate of received frames.
             */
            frames_per_s: number;
            /**
             * Format: int64
             * @description Frames received.
             */
            frames_received: number;
            /**
             * Format: int64
             * @description Frames discarded because their signature was missing, wrong or not newer than the last.
             */
            frames_refused: number;
            /**
             * Format: int64
             * @description Frames sent.
             */
            frames_sent: number;
            /**
             * Format: int64
             * @description Bytes outside of any frame.
             */
            garbage_bytes: number;
            /**
             * Format: int32
             * @description Id of the link.
             */
            id: number;
            /** @description Address and port of its own socket; null while it is not up. */
            local_address: string | null;
            /**
             * Format: double
             * @description Share of all frames that were lost, percent.
             */
            loss_pct: number | null;
            /** @description Name of the link. */
            name: string;
            /** @description Where on this link another station with our own MAVLink address is heard; null when there is none. */
            namesake: string | null;
            /**
             * Format: double
             * @description Share of recent frames that were lost, percent.
             */
            recent_loss_pct: number | null;
            /**
             * Format: double
             * @description Round-trip time of the newest TIMESYNC exchange.
             */
            round_trip_ms: number | null;
            /** @description State of the link. */
            state: components["schemas"]["LinkState"];
        };
        /**
         * @description State of a link.
         * @enum {string}
         */
        LinkState: "connecting" | "up" | "down" | "ended";
        /** @description A stretch in which the plane is too low. */
        LowStretch: components["schemas"]["Clearance"] & {
            /**
             * Format: double
             * @description Way flown until its last place, metres.
             */
            to_m: number;
        };
        /** @description An offline area. */
        MapArea: {
            /**
             * Format: int64
             * @description Bytes that were fetched for it.
             */
            bytes: number;
            /**
             * Format: int64
             * @description Seconds since 1970.
             */
            created_at: number;
            /** @description Why it waits, or what failed. */
            detail: string | null;
            /**
             * Format: int64
             * @description Tiles that are here, or that the service has not.
             */
            done: number;
            /**
             * Format: int64
             * @description Tiles that could not be had.
             */
            failed: number;
            /** @description Its id. */
            id: string;
            /**
             * Format: int32
             * @description Finest level of the source's grid.
             */
            max_level: number;
            /**
             * Format: int32
             * @description Coarsest level of the source's grid.
             */
            min_level: number;
            /** @description Display name. */
            name: string;
            /**
             * Format: double
             * @description How fast it goes.
             */
            rate_tiles_s: number | null;
            /** @description Where it is. */
            shape: components["schemas"]["MapAreaShape"];
            /** @description The source that it is of. */
            source: string;
            /** @description How it stands. */
            state: components["schemas"]["MapAreaState"];
            /**
             * Format: int64
             * @description Tiles in all.
             */
            tiles: number;
        };
        /** @description Size of an area before it is fetched. */
        MapAreaEstimate: {
            /**
             * Format: int64
             * @description Still to be fetched, about.
             */
            bytes: number;
            /**
             * Format: int64
             * @description Already here.
             */
            have: number;
            /** @description By level. */
            levels: components["schemas"]["MapLevelCount"][];
            /**
             * Format: int64
             * @description Tiles that are taken at most.
             */
            max_tiles: number;
            /** @description Why it would be refused. */
            refused: string | null;
            /**
             * Format: int64
             * @description Of a tile.
             */
            tile_bytes: number;
            /** @description Whether that is measured on tiles of this source, or only usual. */
            tile_bytes_measured: boolean;
            /**
             * Format: int64
             * @description In all.
             */
            tiles: number;
        };
        /** @description An area on the ground. */
        MapAreaShape: (components["schemas"]["MapBounds"] & {
            /** @enum {string} */
            kind: "box";
        }) | {
            /** @enum {string} */
            kind: "polygon";
            /** @description In order. */
            points: components["schemas"]["MapCorner"][];
        } | {
            /**
             * Format: double
             * @description How near.
             */
            buffer_m: number;
            /** @enum {string} */
            kind: "route";
            /** @description In order; one is enough. */
            points: components["schemas"]["MapCorner"][];
        };
        /**
         * @description State of an area.
         * @enum {string}
         */
        MapAreaState: "running" | "paused" | "done" | "failed";
        /** @description Who is to be named with a map, as plain text. */
        MapAttribution: {
            /** @description What to show. */
            text: string;
            /** @description Where it leads. */
            url?: string | null;
        };
        /** @description Attributions for a view of the map. */
        MapAttributions: {
            /** @description Plain texts with links. */
            attribution: components["schemas"]["MapAttribution"][];
            /**
             * Format: int32
             * @description Highest zoom at which the view has images.
             */
            max_zoom: number | null;
        };
        /** @description A rectangle of the Earth. West greater than east: over the date line. */
        MapBounds: {
            /**
             * Format: double
             * @description −180 to 180.
             */
            east_deg: number;
            /**
             * Format: double
             * @description −90 to 90.
             */
            north_deg: number;
            /**
             * Format: double
             * @description −90 to 90.
             */
            south_deg: number;
            /**
             * Format: double
             * @description −180 to 180.
             */
            west_deg: number;
        };
        /** @description How full a source's cache is. */
        MapCacheState: {
            /**
             * Format: int64
             * @description On disk.
             */
            bytes: number;
            /**
             * Format: int64
             * @description Bytes at most, but for offline areas.
             */
            max_bytes: number;
            /**
             * Format: int64
             * @description Tiles of offline areas, which are never dropped.
             */
            pinned_tiles: number;
            /**
             * Format: int64
             * @description Tiles, absent ones included.
             */
            tiles: number;
        };
        /**
         * @description What may be kept of a service's tiles.
         * @enum {string}
         */
        MapCaching: "keep" | "headers" | "none";
        /** @description A layer that a service offers. */
        MapCapLayer: {
            /** @description Abstract. */
            abstract: string | null;
            attribution: components["schemas"]["MapAttribution"] | null;
            bounds: components["schemas"]["MapBounds"] | null;
            /** @description Coordinate reference systems that both sides know. */
            crs: string[];
            /**
             * Format: int32
             * @description How deep under other layers.
             */
            depth: number;
            /** @description WMTS: its formats. */
            formats: string[];
            /** @description WMTS: its matrix sets that both sides know. */
            matrix_sets: components["schemas"]["MapCapMatrixSet"][];
            /**
             * Format: int32
             * @description Zoom up to which it shows something.
             */
            max_zoom: number | null;
            /**
             * Format: int32
             * @description Zoom from which it shows something.
             */
            min_zoom: number | null;
            /** @description To ask with; null for a heading. */
            name: string | null;
            /** @description Whether it hides what is under it. */
            opaque: boolean;
            /**
             * Format: int32
             * @description How many more it knows.
             */
            other_crs: number;
            /** @description Its styles, the default first. */
            styles: components["schemas"]["MapCapStyle"][];
            /** @description To show. */
            title: string;
        };
        /** @description A set of tile matrices that a WMTS layer comes in. */
        MapCapMatrixSet: {
            /** @description Its coordinate reference system. */
            crs: string;
            /** @description To ask with. */
            id: string;
            /**
             * Format: int32
             * @description Matrices.
             */
            levels: number;
        };
        /** @description A style of a layer. */
        MapCapStyle: {
            /** @description To ask with. */
            name: string;
            /** @description To show. */
            title: string;
        };
        /** @description Capabilities of a service. */
        MapCapabilities: {
            /** @description Abstract. */
            abstract: string | null;
            /** @description Access constraints. */
            access_constraints: string | null;
            attribution: components["schemas"]["MapAttribution"] | null;
            /** @description Fees. */
            fees: string | null;
            /** @description Formats of its pictures that browsers show. */
            formats: string[];
            /** @description WMS or WMTS. */
            kind: components["schemas"]["MapSourceKind"];
            /** @description Layers, parents first. */
            layers: components["schemas"]["MapCapLayer"][];
            /** @description Title of the service. */
            title: string | null;
            /** @description The version that it answered with. */
            version: string;
        };
        /** @description All settings, for an editor. */
        MapConfiguration: {
            /**
             * Format: int32
             * @description Megabytes of the cache of a source without its own limit.
             */
            cache_max_mb: number;
            /** @description The file of the sources. */
            file: string;
            /** @description The fault of the file. */
            file_error: string | null;
            /** @description The maps folder, on the server's machine. */
            folder: string;
            /** @description In the order of [`MapSources`], without keys. */
            sources: components["schemas"]["MapSourceSettings"][];
        };
        /** @description A place on the ground. */
        MapCorner: {
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
        };
        /**
         * @description How heights are written in pictures.
         * @enum {string}
         */
        MapEncoding: "terrarium" | "terrain-rgb";
        /** @description A file in the maps folder. */
        MapFileInfo: {
            /**
             * Format: int64
             * @description Size of the file.
             */
            bytes: number;
            kind: components["schemas"]["MapSourceKind"] | null;
            /** @description Path, as used in a source's `path`. */
            path: string;
        };
        /** @description An imported file and settings for a source that reads it. */
        MapFileTaken: {
            /**
             * Format: int64
             * @description Size of the file.
             */
            bytes: number;
            /** @description Path, as used in a source's `path`. */
            path: string;
            /** @description Proposed settings; the client sends them back, changed or not, to create the source. */
            settings: components["schemas"]["MapSourceSettings"];
        };
        /** @description A kind of source as forms and programs need to know it. */
        MapKind: {
            /**
             * @description Parts of addresses that indicate a service of this kind, in lower case: placeholders such as `{x}` weigh most,
             *     then queries such as `service=wms`, then the ends of files, and words of the path least.
             */
            address_signs: string[];
            /** @description Settings that it takes in addition to those of all kinds. */
            fields: string[];
            /** @description Ends of the names of files that can be handed in, in small letters, such as `.mbtiles`. */
            file_ends: string[];
            /** @description Whether a service of this kind has capabilities. */
            has_capabilities: boolean;
            /** @description Its name. */
            kind: components["schemas"]["MapSourceKind"];
            /** @description Whether its service demands a key, whatever the address is. */
            needs_key: boolean;
            /** @description Roles that its sources can have; the first is the default. */
            roles: components["schemas"]["MapRole"][];
        };
        /** @description One level of a grid. */
        MapLevel: {
            /** @description Top left corner of tile 0/0: easting or longitude, northing or latitude. */
            origin: number[];
            /**
             * Format: double
             * @description Units of the grid's system a pixel.
             */
            resolution: number;
            /** @description Columns and rows. */
            size: number[] | null;
            /** @description Width and height of a tile. */
            tile_px: number[];
        };
        /** @description How many tiles of one level. */
        MapLevelCount: {
            /**
             * Format: int32
             * @description Which.
             */
            level: number;
            /**
             * Format: int64
             * @description How many.
             */
            tiles: number;
        };
        /** @description Whether offline areas may be made of a source. */
        MapOffline: {
            /** @description Whether. */
            allowed: boolean;
            /** @description Why not. */
            reason: string | null;
        };
        /** @description Ids of map sources in drawing order. */
        MapOrder: {
            /** @description All ids or some of them; the others keep their positions. */
            ids: string[];
        };
        /** @description A source that can be added as it is. */
        MapPreset: {
            /** @description Its content, and the requirements of its terms. */
            description: string;
            /** @description Of its settings. */
            id: string;
            /** @description Where to get one. */
            key_url: string | null;
            /** @description Display name. */
            name: string;
            /** @description Whether the user needs a key. */
            needs_key: boolean;
            /** @description To be put as they are, with the key. */
            settings: components["schemas"]["MapSourceSettings"];
            /** @description Where the terms are. */
            terms_url: string | null;
        };
        /**
         * @description Role of a source.
         * @enum {string}
         */
        MapRole: "base" | "overlay" | "elevation";
        /** @description A source as it is shown. */
        MapSource: {
            /** @description Whom to name with it, always. */
            attribution: components["schemas"]["MapAttribution"][];
            /** @description Whether whom to name depends on the view. */
            attribution_by_view: boolean;
            bounds: components["schemas"]["MapBounds"] | null;
            /** @description Corners of a picture: top left, top right, bottom right, bottom left; null for other kinds. */
            corners: components["schemas"]["MapCorner"][] | null;
            grid: components["schemas"]["MapTileGrid"] | null;
            /** @description Whether there is one. */
            has_key: boolean;
            /** @description Its id. */
            id: string;
            /** @description How it is read. */
            kind: components["schemas"]["MapSourceKind"];
            /** @description Whose logo must be shown on the map: `google`. */
            logo: string | null;
            /**
             * Format: int32
             * @description Zoom of its finest tiles, as its settings say.
             */
            max_zoom: number | null;
            /** @description Whether what was seen is kept for when the network is gone. */
            may_cache: boolean;
            /**
             * Format: int32
             * @description Zoom (of Web Mercator) from which it is shown.
             */
            min_zoom: number | null;
            /** @description Display name. */
            name: string;
            /** @description Whether its service demands a key. */
            needs_key: boolean;
            /** @description Whether offline areas of it are allowed. */
            offline: components["schemas"]["MapOffline"];
            /**
             * Format: double
             * @description 0 to 1.
             */
            opacity: number;
            /**
             * Format: int32
             * @description Place among the others of its role.
             */
            order: number;
            /** @description Its role. */
            role: components["schemas"]["MapRole"];
            /** @description How it fares. */
            state: components["schemas"]["MapSourceState"];
            /** @description Address of its tiles, with `{z}`, `{x}`, `{y}` (from the top). */
            tiles_url: string;
            /** @description Whether it is shown at first. */
            visible: boolean;
        };
        /**
         * @description Why a source does not come, by a stable code with what a sentence about it needs: codes and fields are those of the
         *     causes that a tile is refused with.
         */
        MapSourceCause: {
            /** @enum {string} */
            code: "source-key";
            /** @description Id of the source. */
            source: string;
        } | {
            /** @enum {string} */
            code: "source-invalid";
            /** @description Why, in English. */
            problem: string;
            /** @description Id of the source. */
            source: string;
        } | {
            /** @enum {string} */
            code: "source-failed";
            /** @description In its own words where it gave some. */
            problem: string;
            /** @description Host of the service. */
            service: string;
            /**
             * Format: int32
             * @description The HTTP status, where that is what was wrong.
             */
            status: number | null;
        } | {
            /** @enum {string} */
            code: "source-local";
            /** @description Whether the setting `local_network` of the source would permit it. */
            is_permissible: boolean;
            /** @description Why, and what to do, in English. */
            problem: string;
            /** @description Host of the service. */
            service: string;
        } | {
            /** @enum {string} */
            code: "source-timeout";
            /** @description Host of the service. */
            service: string;
            /**
             * Format: int64
             * @description How long it was given.
             */
            waited_s: number;
        } | {
            /** @enum {string} */
            code: "source-offline";
            /** @description Why, in English. */
            problem: string;
            /**
             * Format: int64
             * @description When it is tried again.
             */
            retry_s: number;
            /** @description Host of the service. */
            service: string;
            /** @description Why, as far as that is known. */
            why: components["schemas"]["MapUnreached"];
        };
        /**
         * @description How a source is read.
         * @enum {string}
         */
        MapSourceKind: "xyz" | "wms" | "wmts" | "google" | "mbtiles" | "pmtiles" | "folder" | "geotiff" | "image" | "dem";
        /** @description The settings of one source. What is absent has its default. */
        MapSourceSettings: {
            /** @description Who is to be named. */
            attribution?: components["schemas"]["MapAttribution"][];
            /** @description Address of the attribution for a view, with `{west} {south} {east} {north} {zoom} {key}`. */
            attribution_url?: string | null;
            /**
             * @description Elevation from tiles and GeoTIFF: heights below sea level are land, as in the Netherlands or at the Dead Sea.
             *     Without it they are the sea's floor, and the ground is the water's surface, 0 m.
             */
            below_sea_level?: boolean;
            bounds?: components["schemas"]["MapBounds"] | null;
            /** @description What may be kept. */
            cache?: components["schemas"]["MapCaching"];
            /**
             * Format: int32
             * @description Days that a tile is taken for new at least, whatever the service says.
             */
            cache_min_days?: number | null;
            /** @description Image: its corners: top left, top right, bottom right, bottom left of the picture. */
            corners?: components["schemas"]["MapCorner"][];
            /** @description WMS: coordinate reference system, such as `EPSG:3857`, the default. */
            crs?: string | null;
            /** @description Elevation: the geoid that its heights are above; `EGM96` when absent. Heights above an ellipsoid are refused. */
            datum?: string | null;
            encoding?: components["schemas"]["MapEncoding"] | null;
            /** @description WMS, WMTS: format of the pictures; WMS default `image/png`. */
            format?: string | null;
            /** @description Whether there is a key. Ignored in a request. */
            has_key?: boolean | null;
            /** @description 1 to 40 of `a`–`z`, `0`–`9`, `-`, `_`. */
            id: string;
            /** @description The user's key for the service. Written, never read: absent keeps it, empty removes it. */
            key?: string | null;
            /** @description How it is read. */
            kind: components["schemas"]["MapSourceKind"];
            /** @description Google: language of the labels, such as `es-ES`. */
            language?: string | null;
            /** @description WMTS: the layer. */
            layer?: string | null;
            /** @description WMS: layers, bottom first. */
            layers?: string[];
            /**
             * @description Whether the service is in this network, or on this machine: without it no private address is asked. Those of the
             *     link itself (169.254.0.0/16, fe80::/10) are never asked.
             */
            local_network?: boolean;
            /** @description Google: `satellite` (the default), `roadmap` or `terrain`. */
            map_type?: string | null;
            /** @description WMTS: the matrix set. */
            matrix_set?: string | null;
            /**
             * Format: int32
             * @description Megabytes of its cache; the file's `cache_max_mb` when absent.
             */
            max_mb?: number | null;
            /**
             * Format: int32
             * @description Zoom of the finest tiles.
             */
            max_zoom?: number | null;
            /**
             * Format: int32
             * @description Zoom (of Web Mercator) from which it is shown; for tiles also the coarsest that are asked for.
             */
            min_zoom?: number | null;
            /** @description Display name. */
            name: string;
            /**
             * @description Whether offline areas of it are allowed.
             * @default true
             */
            offline: boolean;
            /** @description Why not. */
            offline_reason?: string | null;
            /**
             * Format: double
             * @description 0 to 1.
             * @default 1
             */
            opacity: number;
            /**
             * Format: int32
             * @description Place among the others of its role, lowest first.
             */
            order?: number;
            /**
             * Format: int32
             * @description Fetches at once, 1 to 16, default 4.
             */
            parallel?: number | null;
            /** @description WMS: further parameters, such as `TIME`. WMTS: dimensions. */
            parameters?: {
                [key: string]: string;
            };
            /** @description Files: where, relative to the maps folder. */
            path?: string | null;
            /** @description Google: region whose borders are shown, such as `ES`. */
            region?: string | null;
            /** @description Its role. */
            role?: components["schemas"]["MapRole"];
            /** @description WMTS: the style; the layer's default when absent. */
            style?: string | null;
            /** @description WMS: a style for each layer, or empty for their defaults. */
            styles?: string[];
            /** @description For `{s}`. */
            subdomains?: string[];
            /** @description Where its terms are. */
            terms_url?: string | null;
            /**
             * Format: int32
             * @description Tiles: pixels of their side, 64 to 2048, default 256.
             */
            tile_px?: number | null;
            /** @description XYZ, folder: rows are counted from the bottom. */
            tms?: boolean;
            /** @description WMS: whether what is empty is to be transparent. */
            transparent?: boolean | null;
            /**
             * @description XYZ: address with `{z} {x} {y}`, or `{-y}`, `{q}`, `{s}`, `{switch:a,b}`, `{key}`. WMS, WMTS: the service's
             *     address. GeoTIFF: its address, where it is read over the network.
             */
            url?: string | null;
            /** @description WMS: `1.1.1` or `1.3.0`, the default. */
            version?: string | null;
            /**
             * @description Whether it is shown at first.
             * @default true
             */
            visible: boolean;
        };
        /** @description How a source fares. */
        MapSourceState: {
            /**
             * Format: int64
             * @description Bytes that came from the service.
             */
            bytes_fetched: number;
            cache: components["schemas"]["MapCacheState"] | null;
            cause: components["schemas"]["MapSourceCause"] | null;
            /** @description Why, in the service's words where it gave some. */
            detail: string | null;
            /**
             * Format: int64
             * @description Tiles that could not be had.
             */
            failed: number;
            /**
             * Format: int64
             * @description Tiles that came from the service.
             */
            fetched: number;
            /**
             * Format: int64
             * @description Tiles from the cache.
             */
            hits: number;
            /** @description The newest error, though it may be over. */
            last_error: string | null;
            /**
             * Format: int64
             * @description Seconds since 1970.
             */
            last_error_at: number | null;
            /**
             * Format: int64
             * @description Seconds since 1970.
             */
            last_success_at: number | null;
            /**
             * Format: int64
             * @description Tiles that the service said to be unchanged.
             */
            revalidated: number;
            /**
             * Format: int64
             * @description Old tiles that were shown since the service failed.
             */
            stale: number;
            /** @description In a word. */
            status: components["schemas"]["MapSourceStatus"];
        };
        /**
         * @description Status of a source.
         * @enum {string}
         */
        MapSourceStatus: "unused" | "ok" | "failing" | "offline" | "invalid" | "key_missing" | "set_aside";
        /** @description All sources as they are shown. */
        MapSources: {
            /** @description Where their file is, for operators; empty for viewers. */
            file: string;
            /** @description The fault of the file; the last valid one is in use. */
            file_error: string | null;
            /** @description Base maps, overlays from the bottom, heights; each in their order. */
            sources: components["schemas"]["MapSource"][];
        };
        /** @description A grid of tiles in the source's own coordinate reference system. */
        MapTileGrid: {
            /** @description Its system, such as `EPSG:25830`. Coordinates are easting or longitude first, always. */
            crs: string;
            /** @description Where there is something: least x and y, greatest x and y. */
            extent: number[] | null;
            /** @description The levels, coarse to fine; `z` of a tile's address is the index. */
            levels: components["schemas"]["MapLevel"][];
            /**
             * Format: int32
             * @description Finest level with tiles.
             */
            max_level: number;
            /**
             * Format: int32
             * @description Coarsest level with tiles.
             */
            min_level: number;
            /** @description Definition of the system for proj4; null for EPSG:3857 and 4326, which browsers know. */
            proj4: string | null;
        };
        /**
         * @description Why a service is not reached.
         * @enum {string}
         */
        MapUnreached: "name_unknown" | "refused" | "no_connection";
        /** @description A MAVLink message: its name in the dialect, or its number. */
        MessageChoice: number | string;
        /** @description Value of a message field; null stands for NaN. */
        MessageField: (number | null) | (number | null)[] | string;
        /** @description Requested rate of a message. */
        MessageRate: {
            rate_hz: components["schemas"]["RateChoice"] | null;
        };
        /**
         * @description Which part of a position is missing.
         * @enum {string}
         */
        MissingPart: "place" | "height";
        /** @description MISSION_CURRENT, with the numbers of the wire: on ArduPilot item 0 is home. */
        MissionCurrent: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: int32
             * @description Number of the item in execution on the wire.
             */
            seq: number;
            /**
             * @description `"no mission"`, `"not started"`, `"active"`, `"paused"` or `"complete"`; null when the vehicle does not
             *     say.
             */
            state: string | null;
            /**
             * Format: int32
             * @description Items on board, home not counted, 0 where there is no mission; null when not reported.
             */
            total: number | null;
        };
        /** @description The end of a mission. */
        MissionEnd: {
            /**
             * @description The first item of that landing where it is as one is designed, so that parts of it can be moved; null where it
             *     is not.
             */
            designed_item: number | null;
            /**
             * @description The first item of the landing that ends it, its approach with it, or the return; counted from 1, the number of
             *     items plus one where it ends with neither. What is added "at the end" belongs before it.
             */
            item: number;
        };
        /** @description Automatic flight and mission progress of a vehicle. */
        MissionProgress: {
            /**
             * Format: double
             * @description Time on that circle by the vehicle's clock; null in the same cases.
             */
            circled_s: number | null;
            /**
             * Format: double
             * @description Turns flown of the circle at the current item; null while it circles at none, and when the beginning of the
             *     circle was not heard.
             */
            circled_turns: number | null;
            /**
             * Format: double
             * @description Distance over ground to the end of the mission.
             */
            distance_m: number | null;
            /** @description Whether its mode flies the mission; null while its mode is unknown. */
            follows_mission: boolean | null;
            /** @description Whether the mission has been completed. */
            is_complete: boolean;
            /**
             * @description Whether it is descending to land, so that the landing can be aborted; null when unknown, as in a mission that
             *     was not read.
             */
            is_landing: boolean | null;
            /**
             * Format: int32
             * @description Current item, counted from 1.
             */
            item: number | null;
            /**
             * Format: double
             * @description Distance to the current item.
             */
            leg_distance_m: number | null;
            preparation: components["schemas"]["FlightPreparation"] | null;
            /** @description Reached items, ascending. */
            reached: number[];
            /**
             * Format: double
             * @description An alarm: distance between the position it flies to and the current item of the plan that was read from it; null
             *     when there is no alarm.
             */
            target_off_m: number | null;
            /**
             * Format: double
             * @description Time for that distance at the present speed.
             */
            time_s: number | null;
            /**
             * Format: int32
             * @description Number of items in the mission.
             */
            total: number | null;
            /**
             * Format: double
             * @description Turn rate of its course while it circles by itself, clockwise positive; null in other modes, and when unknown.
             */
            turn_rate_deg_s: number | null;
        };
        /** @description A flight mode as a caller names it. */
        ModeChoice: number | string;
        /** @description A named camera model. */
        NamedCamera: {
            /** @description Camera data. */
            camera: components["schemas"]["Camera"];
            /** @description Name, as QGroundControl has it where it knows the camera. */
            name: string;
        };
        /** @description NAV_CONTROLLER_OUTPUT: targets and errors of the navigation controller. */
        NavController: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Airspeed error, target faster positive.
             */
            airspeed_error_m_s: number | null;
            /**
             * Format: double
             * @description Altitude error, target above positive.
             */
            alt_error_m: number | null;
            /**
             * Format: double
             * @description Distance off the track, right of it positive.
             */
            cross_track_error_m: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Desired heading, -180 to 180.
             */
            nav_bearing_deg: number | null;
            /**
             * Format: double
             * @description Desired pitch.
             */
            nav_pitch_deg: number | null;
            /**
             * Format: double
             * @description Desired roll.
             */
            nav_roll_deg: number | null;
            /**
             * Format: double
             * @description Bearing to the target, -180 to 180.
             */
            target_bearing_deg: number | null;
            /**
             * Format: double
             * @description Distance to the target.
             */
            wp_distance_m: number | null;
        };
        /** @description A link to open. */
        NewLink: {
            /**
             * @description Whether unsigned frames of a vehicle that must sign are accepted. When absent, the address decides: yes for USB
             *     and loopback.
             */
            accept_unsigned?: boolean | null;
            /** @description Link string, such as `udpin:0.0.0.0:14550`. */
            address: string;
            /** @description Whether frames are forwarded between this link and the others, for another ground station. */
            forward?: boolean;
            /** @description Display name; the link string when absent. */
            name?: string | null;
        };
        /** @description A raw message to send. No answer is awaited. `POST /vehicles/{id}/messages` says what is refused. */
        NewMessage: {
            /** @description Fields. Missing ones are 0, except that `target_system` and `target_component` default to the vehicle's. */
            fields?: {
                [key: string]: components["schemas"]["MessageField"];
            };
            /** @description Message name, such as `SET_POSITION_TARGET_GLOBAL_INT`. */
            name: string;
        };
        /** @description New value of a parameter. */
        NewParam: {
            /**
             * Format: double
             * @description The value.
             */
            value: number;
        };
        /** @description A new version of the draft. */
        NewPlanDraft: {
            /** @description Browser or program that wrote it: an identifier of its choice, up to 64 letters, digits, `-` and `_`. */
            author: string;
            /**
             * Format: int64
             * @description Revision on which it is based; 0 when there was none.
             */
            base: number;
            /** @description The plan. */
            plan: Record<string, never>;
        };
        /** @description A recording to replay: one of `GET /recordings`, or with `place` one of `GET /history`. */
        NewReplay: {
            /** @description File name. */
            name: string;
            /** @description Place of a history file: the fleet, or `_board`. */
            place?: string | null;
            /**
             * Format: double
             * @description Position at which to begin; 0 by default.
             */
            position_s?: number | null;
            /**
             * Format: double
             * @description Times the recorded pace, 0.01 to 10,000; 1 by default.
             */
            speed?: number | null;
        };
        /** @description Request for a session. */
        NewSession: {
            /** @description Display name, up to 40 characters. */
            name?: string | null;
            /** @description Access token, printed on the server's terminal; required when `GET /info` says so. */
            token?: string | null;
        };
        /**
         * @description Why a vehicle accepts only missions, and neither fences nor rally points.
         * @enum {string}
         */
        OnlyMissionReason: "old_firmware" | "mavlink1";
        /** @description A long-running operation. */
        Operation: {
            /**
             * Format: int32
             * @description Progress, in units of `total`.
             */
            done: number;
            /** @description Why it failed. */
            error?: components["schemas"]["Problem"];
            /**
             * Format: int64
             * @description Id of the operation.
             */
            id: number;
            /** @description Kind of the operation. */
            kind: components["schemas"]["OperationKind"];
            /**
             * Format: double
             * @description After an upload to a vehicle that stores positions as 32-bit floats: largest distance between a position on
             *     board and the one that was sent.
             */
            position_error_m?: number;
            /** @description The result; only at `GET /operations/{id}`, once the operation is done. */
            result?: components["schemas"]["OperationResult"];
            /** @description State of the operation. */
            state: components["schemas"]["OperationState"];
            /**
             * Format: int32
             * @description Total amount of work; 0 when not known yet.
             */
            total: number;
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        };
        /**
         * @description Kind of an operation.
         * @enum {string}
         */
        OperationKind: "upload_mission" | "upload_fence" | "upload_rally" | "download_mission" | "download_fence" | "download_rally" | "clear_mission" | "clear_fence" | "clear_rally" | "read_params";
        /** @description Result of an operation. */
        OperationResult: components["schemas"]["Plan"] | components["schemas"]["Param"][];
        /**
         * @description State of an operation.
         * @enum {string}
         */
        OperationState: "running" | "done" | "failed" | "cancelled";
        /**
         * @description How a profile of an airframe came about.
         * @enum {string}
         */
        Origin: "parameters" | "simulator" | "flight";
        /** @description Comparison of a flight with its forecast; values are null when unknown, for example away from the expected track. */
        Outlook: {
            /**
             * Format: double
             * @description Expected charge at the end of `ahead` if consumption continues as since the beginning; null until 2 % have been
             *     used.
             */
            battery_pct: number | null;
            /**
             * Format: double
             * @description Delay; negative when early.
             */
            late_s: number | null;
            /**
             * Format: double
             * @description Altitude below the forecast, metres; negative when above it. Null during take-off and fast changes of altitude.
             */
            low_m: number | null;
        };
        /** @description A parameter of the vehicle. */
        Param: {
            /**
             * Format: double
             * @description Default value on this vehicle; null when it is not reported. Only lists read over MAVFTP from an ArduPilot since
             *     4.2 report it.
             */
            default: number | null;
            /** @description MAVLink type: `int8` … `real32`. */
            kind: string;
            /** @description Name. */
            name: string;
            /**
             * Format: double
             * @description Value.
             */
            value: number;
        };
        /** @description Differences in one part of a plan. */
        PartComparison: {
            /** @description Changes from the plan on board to this plan; empty when the vehicle, with its storage precision, already has it. */
            changes: components["schemas"]["PlanChange"][];
            /** @description Fingerprint (as in `PlanState`) of the part on board that was compared; null when there is none on board. */
            hash: string | null;
        };
        /** @description A plan: mission, fence and rally points. */
        Plan: {
            /**
             * @description Groups of mission items that a `.plan` file stores as one complex item, kept so that the file can be written
             *     unchanged.
             */
            complex_items?: components["schemas"]["ComplexItem"][];
            /** @description Geofence. */
            fence: components["schemas"]["Fence"];
            home: components["schemas"]["Home"] | null;
            /** @description Mission items in order, without home. */
            items: components["schemas"]["PlanItem"][];
            planned_for?: components["schemas"]["PlannedFor"] | null;
            /** @description Rally points: where to return to when home is farther. */
            rally: components["schemas"]["RallyPoint"][];
        };
        /**
         * @description Certainty about a plan on board.
         * @enum {string}
         */
        PlanCertainty: "unknown" | "empty" | "verified";
        /** @description One step from the list on board to the one that is edited. Numbers count from 1, home of a mission left out. */
        PlanChange: {
            /** @description Its number in the plan that is edited. */
            item: number;
            /** @enum {string} */
            kind: "added";
        } | {
            /** @enum {string} */
            kind: "removed";
            /** @description Its number on board. */
            on_board: number;
        } | {
            /** @description The fields that have changed, in this order. */
            fields: components["schemas"]["ChangedField"][];
            /** @description Its number in the plan that is edited. */
            item: number;
            /** @enum {string} */
            kind: "changed";
            /** @description The number of the one on board. */
            on_board: number;
        };
        /** @description A plan to check. */
        PlanCheck: {
            /** @description The plan. */
            plan: components["schemas"]["Plan"];
            /**
             * Format: int32
             * @description Vehicle that is to fly it. Its type, its position and whether it is on the ground are considered.
             */
            vehicle?: number | null;
        };
        /** @description Differences between a plan and the one on board, by part; a part is null while its state on board is unknown. */
        PlanComparison: {
            fence: components["schemas"]["PartComparison"] | null;
            mission: components["schemas"]["PartComparison"] | null;
            rally: components["schemas"]["PartComparison"] | null;
        };
        /** @description Draft of a plan, shared by all operators. */
        PlanDraft: {
            /** @description Browser or program that wrote it. */
            author: string;
            /** @description Name of the session that wrote it. */
            by: string;
            /** @description The plan as written by its author; readers must validate it. */
            plan: Record<string, never>;
            /**
             * Format: int64
             * @description Revision number, incremented with each change.
             */
            revision: number;
            /**
             * Format: double
             * @description Time of saving, seconds since 1970 on the server's clock.
             */
            saved_unix_s: number;
        };
        /** @description The current draft and conflicting drafts. */
        PlanDrafts: {
            current: components["schemas"]["PlanDraft"] | null;
            /** @description Drafts that lost a race or were overwritten by another author, newest first, at most one per author. */
            others: components["schemas"]["PlanDraft"][];
        };
        /** @description One thing that a file did not say, could not say, or said in vain. */
        PlanFileNote: {
            /** @description What. */
            code: components["schemas"]["PlanFileNoteCode"];
            /** @description How many heights, items, areas… it concerns; at least 1. */
            count: number;
        };
        /**
         * @description Kind of note about a plan file, as in `heights-missing`.
         * @enum {string}
         */
        PlanFileNoteCode: "heights-above-sea-level" | "heights-above-terrain" | "heights-taken-above-sea-level" | "heights-taken-above-home" | "heights-missing" | "not-places" | "points-left-out" | "tracks-left-out" | "items-missing" | "items-renumbered" | "items-elsewhere" | "lines-joined" | "areas-taken-as-fence" | "holes-taken-as-fence" | "area-heights-not-kept" | "names-not-kept" | "rally-landings-not-kept" | "heights-written-above-sea-level" | "heights-not-written" | "heights-drawn-above-sea-level" | "heights-not-drawn" | "commands-not-written" | "items-not-written" | "home-not-written" | "fence-not-written" | "rally-not-written" | "complex-items-edited" | "settings-not-written";
        /** @description One item of a mission. */
        PlanItem: {
            /** @description Whether the mission continues with the next item by itself. */
            autocontinue: boolean;
            /**
             * Format: int32
             * @description `MAV_CMD` number.
             */
            command: number;
            /**
             * Format: int32
             * @description `MAV_FRAME`: 0 above mean sea level, 3 above home, 10 above terrain, 2 no position.
             */
            frame: number;
            /** @description Name of the command without `MAV_CMD_`. Ignored in requests. */
            name: string;
            /** @description Parameters 1 to 4, then latitude, longitude and altitude of a command with a position; null where unset. */
            params: [
                number | null,
                number | null,
                number | null,
                number | null,
                number | null,
                number | null,
                number | null
            ];
        };
        /**
         * @description Part of a plan.
         * @enum {string}
         */
        PlanKind: "mission" | "fence" | "rally";
        /** @description One part of the plan on board, as far as it is known. */
        PlanOnBoard: {
            plan: components["schemas"]["Plan"] | null;
            /** @description State of that part. */
            state: components["schemas"]["PlanState"];
        };
        /** @description State of a plan on board. */
        PlanState: {
            /**
             * Format: int32
             * @description Number of items, without home; null when unknown.
             */
            count: number | null;
            /** @description Description in English. */
            detail: string;
            /** @description Fingerprint of the items as the vehicle stores them; null when unknown. */
            hash: string | null;
            /**
             * @description Whether it may be a mixture of two plans. If so, the vehicle is not armed, and its mission is neither started
             *     nor set to another item, unless the request says `despite_mixed_plan`.
             */
            may_be_mixed: boolean;
            /** @description Why it is unknown; absent when it is known. */
            reason?: components["schemas"]["PlanUncertainty"];
            /** @description Certainty about the plan. */
            state: components["schemas"]["PlanCertainty"];
        };
        /** @description States of the plans on board. */
        PlanStates: {
            /** @description The fence. */
            fence: components["schemas"]["PlanState"];
            /** @description The mission. */
            mission: components["schemas"]["PlanState"];
            /** @description The rally points. */
            rally: components["schemas"]["PlanState"];
        };
        /**
         * @description Why a plan on board is unknown.
         * @enum {string}
         */
        PlanUncertainty: "never_read" | "transferring" | "transfer_failed" | "rebooted" | "changed_elsewhere" | "sent_elsewhere" | "record_damaged" | "mixed";
        /** @description Wind that a plan is made for; calm by default. */
        PlanWind: {
            /**
             * Format: double
             * @description Where it comes from, degrees from true north.
             */
            from_deg: number;
            /**
             * Format: double
             * @description Its speed, m/s, 0 to 60.
             */
            speed_m_s: number;
        };
        /** @description Airframe and battery for a rehearsal, in place of the vehicle's own. */
        PlaneProfile: {
            airframe?: components["schemas"]["Airframe"] | null;
            battery?: components["schemas"]["BatterySettings"] | null;
        };
        /** @description A planned flight. */
        PlannedFlight: {
            plan?: components["schemas"]["Plan"] | null;
            /**
             * Format: double
             * @description Start time on a clock common to all flights, 0 to 86,400; 0 when absent.
             */
            starts_s?: number | null;
            /**
             * Format: int32
             * @description Vehicle that is to fly it; a default ArduPlane when absent.
             */
            vehicle?: number | null;
        };
        /**
         * @description The vehicle that a `.plan` file was planned for. QGroundControl offers the commands of this vehicle, and plans times
         *     with its speeds; nothing of it is sent to a vehicle.
         */
        PlannedFor: {
            /**
             * Format: double
             * @description Speed to plan times with, metres per second (airspeed of a plane), 0 to 1000.
             * @default null
             */
            cruise_speed_m_s: number | null;
            /**
             * Format: int32
             * @description `MAV_AUTOPILOT`; 3 is ArduPilot.
             * @default null
             */
            firmware_type: number | null;
            /**
             * Format: double
             * @description Speed of a vehicle that hovers, metres per second, 0 to 1000.
             * @default null
             */
            hover_speed_m_s: number | null;
            /**
             * Format: int32
             * @description `MAV_TYPE`; 1 is a fixed-wing plane.
             * @default null
             */
            vehicle_type: number | null;
        };
        /** @description GLOBAL_POSITION_INT: the autopilot's filtered position estimate. */
        Position: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Altitude above mean sea level.
             */
            alt_amsl_m: number | null;
            /**
             * Format: double
             * @description Altitude above home.
             */
            alt_rel_home_m: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Heading, 0 to 360 from true north.
             */
            heading_deg: number | null;
            /**
             * Format: double
             * @description WGS-84 latitude; null without a position.
             */
            lat_deg: number | null;
            /**
             * Format: double
             * @description WGS-84 longitude; null without a position.
             */
            lon_deg: number | null;
            /**
             * Format: double
             * @description Speed downward.
             */
            velocity_down_m_s: number | null;
            /**
             * Format: double
             * @description Ground speed eastward.
             */
            velocity_east_m_s: number | null;
            /**
             * Format: double
             * @description Ground speed northward.
             */
            velocity_north_m_s: number | null;
        };
        /** @description SCALED_PRESSURE: barometer and airspeed sensor. */
        Pressure: {
            /**
             * Format: double
             * @description Static pressure.
             */
            absolute_pa: number | null;
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Differential pressure of the airspeed sensor.
             */
            differential_pa: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Temperature at the barometer.
             */
            temperature_c: number | null;
        };
        /**
         * @description An error (RFC 9457), served as `application/problem+json`. Its texts are English; `cause` carries the same
         *     information for programs, for example to show it in another language.
         */
        Problem: {
            /** @description Machine-readable cause. */
            cause: components["schemas"]["Cause"];
            /** @description What was wrong, where, and how to correct it. */
            detail: string;
            /** @description Texts that the vehicle sent about it, or the differences that were found. */
            reasons?: string[];
            /** @description Kind of each of the vehicle's `reasons`; null when no remedy is known for it. */
            refusals?: (components["schemas"]["RefusalCode"] | null)[];
            /** @description How to resolve it, where that is known. */
            remedy?: string;
            /**
             * Format: int32
             * @description The HTTP status.
             */
            status: number;
            /** @description Short description of the type. */
            title: string;
            /** @description Stable type: `urn:vencejo:` followed by the code of `cause`, such as `urn:vencejo:command-refused`. */
            type: string;
        };
        /** @description The heights of a mission. */
        Profile: {
            ground: components["schemas"]["ProfileGround"] | null;
            /**
             * Format: double
             * @description Way flown in all, metres: circles without end or of unknown length left out.
             */
            length_m: number;
            /** @description Where the plane circles. */
            loiters: components["schemas"]["ProfileLoiter"][];
            /** @description The line, from home or from the first item when home is not known. */
            points: components["schemas"]["ProfilePoint"][];
        };
        /** @description The ground below the way, as far as it is known. */
        ProfileGround: {
            /** @description Way flown until each place at which it was looked up, metres. */
            distance_m: number[];
            /** @description Height of the ground above that at home, metres; null where it is not known. */
            ground_rel_home_m: (number | null)[];
            lowest: components["schemas"]["Clearance"] | null;
            /**
             * @description Where it is too low: below the height that was to be kept, and for take-off and landing in the ground by more
             *     than maps err.
             */
            too_low: components["schemas"]["LowStretch"][];
            /** @description Places whose height is not known. */
            unknown: number;
        };
        /** @description A stretch in which the plane circles at an item. */
        ProfileLoiter: {
            /**
             * Format: double
             * @description Way flown until then, metres.
             */
            from_m: number;
            /** @description Whether its length is not known, though it has one. */
            is_unknown: boolean;
            /** @description The item, counted from 1. */
            item: number;
            /** @description Until when. */
            kind: components["schemas"]["WayCircling"];
            /**
             * Format: double
             * @description Way flown after it, metres: the same when it has no end or its length is not known.
             */
            to_m: number;
        };
        /** @description A point of the line. */
        ProfilePoint: {
            /**
             * Format: double
             * @description Height above home, metres.
             */
            alt_rel_home_m: number;
            /**
             * Format: double
             * @description Way flown since the beginning, metres.
             */
            distance_m: number;
            /** @description Whether it comes after a circle without end, and is flown only when a pilot goes on to it. */
            is_beyond: boolean;
            /** @description Whether that is known; otherwise home or the ground there is not, or the vehicle chooses it, and it is a guess. */
            is_certain: boolean;
            /** @description Whether the item's own height is here: others lead to it, over the ground or round a circle. */
            is_item: boolean;
            /** @description The item that it belongs to, counted from 1; null for home at the beginning. */
            item: number | null;
        };
        /** @description A line whose terrain profile is wanted: points, or a plan. */
        ProfileRequest: {
            plan?: components["schemas"]["Plan"] | null;
            /** @description Points of the line. */
            points?: components["schemas"]["LatLon"][];
            /**
             * Format: double
             * @description Largest distance between samples; 30 when absent. At most 2000 samples are returned.
             */
            spacing_m?: number | null;
        };
        /** @description RADIO_STATUS or RADIO of the telemetry radio. */
        Radio: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: int32
             * @description Packets restored by error correction.
             */
            fixed: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: int32
             * @description Noise on our side, raw.
             */
            noise: number | null;
            /**
             * Format: int32
             * @description Noise on the vehicle's side, raw.
             */
            remote_noise: number | null;
            /**
             * Format: int32
             * @description Received signal on the vehicle's side, raw 0 to 254.
             */
            remote_rssi: number | null;
            /**
             * Format: int32
             * @description Received signal on our side, raw 0 to 254.
             */
            rssi: number | null;
            /**
             * Format: int32
             * @description Packets lost to radio errors.
             */
            rx_errors: number;
            /**
             * Format: int32
             * @description Free transmit buffer, 0 to 100 %.
             */
            tx_buffer_pct: number | null;
        };
        /**
         * @description What is wrong with a rally point.
         * @enum {string}
         */
        RallyFault: "height" | "not-above-home" | "frame";
        /** @description Rally point: a position to return to instead of home. */
        RallyPoint: {
            /**
             * Format: double
             * @description Altitude, in `frame`.
             */
            alt_m: number;
            /**
             * Format: int32
             * @description `MAV_FRAME`: 0 above mean sea level, 3 above home, 10 above terrain.
             */
            frame: number;
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
        };
        /** @description A rate: messages per second, 0.0005 to 50, of which 0 stands for the vehicle's own rate; or a word. */
        RateChoice: number | components["schemas"]["RateWord"];
        /**
         * @description A rate given as a word.
         * @enum {string}
         */
        RateWord: "default" | "stop";
        /** @description A COMMAND_INT, whose position is given as scaled integers in its frame. */
        RawCommandInt: {
            /** @description Command. */
            command: components["schemas"]["CommandChoice"];
            /**
             * Format: int32
             * @description `MAV_FRAME`.
             */
            frame: number;
            /** @description Parameters 1 to 4. Missing ones are 0; null is sent as NaN, which lets the vehicle choose. */
            params?: [
            ] | [
                number | null
            ] | [
                number | null,
                number | null
            ] | [
                number | null,
                number | null,
                number | null
            ] | [
                number | null,
                number | null,
                number | null,
                number | null
            ];
            /**
             * Format: int32
             * @description Parameter 5; degrees × 10⁷ of latitude in a global frame.
             */
            x?: number;
            /**
             * Format: int32
             * @description Parameter 6; degrees × 10⁷ of longitude in a global frame.
             */
            y?: number;
            /**
             * Format: double
             * @description Parameter 7; metres in a global frame.
             */
            z?: number;
        };
        /** @description A COMMAND_LONG. */
        RawCommandLong: {
            /** @description Command. */
            command: components["schemas"]["CommandChoice"];
            /** @description Parameters 1 to 7. Missing ones are 0; null is sent as NaN, which lets the vehicle choose. */
            params?: [
            ] | [
                number | null
            ] | [
                number | null,
                number | null
            ] | [
                number | null,
                number | null,
                number | null
            ] | [
                number | null,
                number | null,
                number | null,
                number | null
            ] | [
                number | null,
                number | null,
                number | null,
                number | null,
                number | null
            ] | [
                number | null,
                number | null,
                number | null,
                number | null,
                number | null,
                number | null
            ] | [
                number | null,
                number | null,
                number | null,
                number | null,
                number | null,
                number | null,
                number | null
            ];
        };
        /** @description A raw MAVLink message. */
        RawMessage: {
            /**
             * Format: int32
             * @description Component id of its sender.
             */
            component_id: number;
            /**
             * @description Fields in the units of the MAVLink definition; enums and bit masks are numbers. Empty when the dialect does not
             *     contain the message.
             */
            fields: {
                [key: string]: components["schemas"]["MessageField"];
            };
            /**
             * Format: int32
             * @description Message id.
             */
            id: number;
            /** @description Message name; `UNKNOWN_12345` when the dialect does not contain it. */
            name: string;
            /**
             * Format: int32
             * @description System id of its sender.
             */
            system_id: number;
            /**
             * Format: double
             * @description Time of reception, seconds on the station's clock.
             */
            time_s: number;
        };
        /** @description RC_CHANNELS: the pilot's radio. */
        RcChannels: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: int32
             * @description Number of channels.
             */
            count: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description Pulse lengths of channels 1 to 18; null for a missing channel. */
            pulse_us: (number | null)[];
            /**
             * Format: int32
             * @description Received signal, raw 0 to 254.
             */
            rssi: number | null;
        };
        /**
         * @description Reaction of the vehicle.
         * @enum {string}
         */
        Reaction: "goes-on" | "flies-mission" | "returns" | "lands" | "goes-around" | "circles" | "glides" | "not-rehearsed";
        /** @description An event of a vehicle in a recording. */
        RecordedEvent: {
            /** @description Kind of the event, such as `mode`, `armed`, `disarmed`, `text`, `item_reached`, `lost`. */
            kind: string;
            /**
             * Format: int32
             * @description System id of the vehicle.
             */
            system_id: number;
            /** @description Description; for `text`, the vehicle's own text. */
            text: string;
            /**
             * Format: double
             * @description Time since the first frame.
             */
            time_s: number;
        };
        /** @description State of the flight recorder. */
        Recorder: {
            /**
             * Format: int64
             * @description Bytes recorded in this session.
             */
            bytes: number;
            /**
             * Format: int64
             * @description Frames lost because the disk was too slow or failed.
             */
            dropped: number;
            /** @description Name of the current file; null when there is none. */
            file: string | null;
            /**
             * Format: int64
             * @description Frames recorded in this session.
             */
            frames: number;
            /** @description Whether frames are being recorded. */
            is_recording: boolean;
            /** @description Why nothing is recorded; null when there is no fault. */
            problem: string | null;
        };
        /** @description A recording on the server's disk. */
        Recording: {
            /**
             * Format: int64
             * @description File size.
             */
            bytes: number;
            /** @description Whether it is being recorded now. */
            is_current: boolean;
            /** @description Whether it is protected from deletion when space for new recordings is needed. */
            is_kept: boolean;
            /**
             * Format: double
             * @description Time of the last change, seconds since 1970; null when the file system does not provide it.
             */
            modified_unix_s: number | null;
            /** @description File name. */
            name: string;
            /**
             * Format: double
             * @description Time of the first frame, seconds since 1970; null when there is none.
             */
            start_unix_s: number | null;
        };
        /** @description Contents of a recording. */
        RecordingSummary: {
            /**
             * Format: double
             * @description Time from the first frame to the last.
             */
            duration_s: number;
            /** @description Events in order. */
            events: components["schemas"]["RecordedEvent"][];
            /**
             * Format: int64
             * @description Number of later events that are not listed, for lack of space.
             */
            events_left_out: number;
            /**
             * Format: int64
             * @description Complete frames.
             */
            frames: number;
            /** @description Number of frames of each message, by name. */
            messages: {
                [key: string]: number;
            };
            /** @description Senders. */
            senders: components["schemas"]["Sender"][];
            /**
             * Format: int64
             * @description Bytes outside of complete frames: damage, or a truncated end.
             */
            skipped_bytes: number;
            /**
             * Format: double
             * @description Time of the first frame, seconds since 1970; null when there is no frame.
             */
            start_unix_s: number | null;
        };
        /**
         * @description Kind of a refusal by the vehicle.
         * @enum {string}
         */
        RefusalCode: "landing-needs-rtl-autoland" | "no-mission" | "mode-not-armable" | "landing-sequence" | "gps-accuracy" | "gps-no-fix" | "position-unknown" | "compass-inconsistent" | "compass-calibrate" | "accels-inconsistent" | "accels-calibrate" | "gyros" | "ahrs-waiting" | "airspeed" | "barometer" | "board-voltage" | "battery-low" | "throttle-not-zero" | "rc-not-calibrated" | "safety-switch" | "failsafe" | "logging" | "fence" | "rally" | "already-armed" | "system-initialising";
        /** @description Rehearsal of a plan in a wind: the flight as simulated. */
        Rehearsal: {
            /** @description Source of the airframe data. */
            airframe: components["schemas"]["Origin"];
            /**
             * @description Position of each track point along the altitude profile of the plan (`plan_way`), metres, in which every item
             *     has its own position. It decreases after a jump.
             */
            along_m: number[];
            battery: components["schemas"]["BatteryLeft"] | null;
            battery_unknown: components["schemas"]["BatteryLack"] | null;
            /**
             * Format: double
             * @description Distance over ground, metres.
             */
            distance_m: number;
            /**
             * Format: double
             * @description Duration, seconds.
             */
            duration_s: number;
            /** @description How the flight ends. */
            ending: components["schemas"]["Ending"];
            /**
             * Format: double
             * @description Electrical energy; null when the plane's power is unknown.
             */
            energy_wh: number | null;
            /** @description Errors and doubts that the rehearsal shows; in an assessment, they are also among the plan's findings. */
            findings: components["schemas"]["Finding"][];
            /** @description Whether terrain below the plan is still being loaded and was left out: repeat the request a moment later. */
            is_ground_pending: boolean;
            /** @description Whether the vehicle's own parameters were read; otherwise a default ArduPlane is assumed. */
            knows_parameters: boolean;
            lowest: components["schemas"]["Clearance"] | null;
            /** @description Items in the order flown; jumps repeat them. */
            passages: components["schemas"]["RehearsedPassage"][];
            touch_down: components["schemas"]["LatLon"] | null;
            /** @description Track, with as many points as are needed to draw it within a metre. */
            track: components["schemas"]["RehearsedTrack"];
            /** @description Wind of the rehearsal. */
            wind: components["schemas"]["PlanWind"];
        };
        /** @description A plan to rehearse. */
        RehearsalRequest: {
            /**
             * Format: double
             * @description Clearance to keep above the ground, 0 to 1000; 30 by default.
             */
            clearance_m?: number | null;
            /** @description The plan; without a home, the vehicle's home is used. */
            plan: components["schemas"]["Plan"];
            /** @description Plane, in place of the vehicle's. */
            profile?: components["schemas"]["PlaneProfile"];
            /**
             * Format: int32
             * @description Vehicle that is to fly it; the plane is modelled by its parameters, as far as they were read.
             */
            vehicle?: number | null;
            wind?: components["schemas"]["PlanWind"] | null;
        };
        /** @description A rehearsed flight from some time to its end. */
        RehearsedFlight: {
            battery: components["schemas"]["BatteryLeft"] | null;
            /**
             * Format: double
             * @description Distance over ground since that beginning, metres.
             */
            distance_m: number;
            /** @description How the flight ends. */
            ending: components["schemas"]["Ending"];
            /**
             * Format: double
             * @description End time, seconds since the beginning of the rehearsed flight.
             */
            ends_s: number;
            /**
             * Format: double
             * @description Electrical energy since that beginning; null when the plane's power is unknown.
             */
            energy_wh: number | null;
            touch_down: components["schemas"]["LatLon"] | null;
            /** @description Track, with as many points as are needed to draw it within a metre. */
            track: components["schemas"]["RehearsedTrack"];
        };
        /** @description Passage of one item. */
        RehearsedPassage: {
            /**
             * Format: double
             * @description Time at which it becomes the current item, seconds.
             */
            begins_s: number;
            /**
             * Format: int32
             * @description Number of the item, counted from 1.
             */
            item: number;
            /**
             * Format: double
             * @description Smallest distance to its position, metres; null for items other than waypoints and landings.
             */
            nearest_m: number | null;
            /**
             * Format: double
             * @description Time at which it is reached or completed; null when it never is.
             */
            reached_s: number | null;
        };
        /** @description Track of a rehearsed flight, as lists of equal length. */
        RehearsedTrack: {
            /** @description Equivalent airspeed, metres per second. */
            airspeed_m_s: number[];
            /** @description Bank angle, degrees, positive to the right. */
            bank_deg: number[];
            /** @description Ground elevation below, above home, metres; null when no map contains it. */
            ground_m: (number | null)[];
            /** @description Ground speed, metres per second. */
            groundspeed_m_s: number[];
            /** @description Heading of the nose, degrees from true north. */
            heading_deg: number[];
            /** @description Altitude above home, metres. */
            height_m: number[];
            /** @description Current item, counted from 1; null during a return and after the landing. */
            item: (number | null)[];
            /** @description Latitude, degrees. */
            lat_deg: number[];
            /** @description Longitude, degrees. */
            lon_deg: number[];
            /** @description Time since its beginning, seconds, ascending. */
            time_s: number[];
        };
        /** @description A recording that is being replayed. Its aircraft are vehicles of their own, which take no commands. */
        Replay: {
            /**
             * Format: double
             * @description Duration of the recording; a pause of more than an hour counts nothing.
             */
            duration_s: number;
            /** @description Why it cannot go on, in English; null when there is no fault. */
            fault: string | null;
            /** @description File name. */
            file: string;
            /**
             * Format: int32
             * @description Id of the replay.
             */
            id: number;
            /** @description Whether it has come to its end. */
            is_over: boolean;
            /** @description Whether it stands still. */
            is_paused: boolean;
            /** @description Name of the aircraft; the file name without its ending when the recording names none. */
            name: string;
            /**
             * Format: double
             * @description Position in the recording, from its beginning.
             */
            position_s: number;
            /**
             * Format: int64
             * @description Number of times that it went to another position. With each, the vehicles begin anew: earlier values are void.
             */
            seeks: number;
            /**
             * Format: int64
             * @description Bytes of the recording that could not be read.
             */
            skipped_bytes: number;
            /**
             * Format: double
             * @description Times the recorded pace.
             */
            speed: number;
            /**
             * Format: double
             * @description Time of the recording's beginning, seconds since 1970; null when unknown.
             */
            start_unix_s: number | null;
            /**
             * Format: double
             * @description Time in the recording now, seconds since 1970; null when unknown.
             */
            unix_s: number | null;
            /** @description Ids of its vehicles. */
            vehicles: number[];
        };
        /** @description Changes of a replay; absent fields stay as they are. */
        ReplayChange: {
            /** @description Whether it stands still. `false` at the end begins again. */
            is_paused?: boolean | null;
            /**
             * Format: double
             * @description Position to go to; beyond the end, the end.
             */
            position_s?: number | null;
            /**
             * Format: double
             * @description Times the recorded pace, 0.01 to 10,000.
             */
            speed?: number | null;
        };
        /** @description Something that happened in a recording. */
        ReplayMark: {
            /** @description What happened. */
            kind: components["schemas"]["ReplayMarkKind"];
            /** @description The new mode; null for other kinds. */
            mode: string | null;
            /**
             * Format: double
             * @description Position in the recording.
             */
            position_s: number;
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        };
        /**
         * @description What happened in a recording.
         * @enum {string}
         */
        ReplayMarkKind: "armed" | "disarmed" | "mode";
        /** @description Position to return to after a breach of the fence. */
        ReturnPoint: {
            /**
             * Format: double
             * @description Altitude above home.
             */
            alt_rel_home_m: number;
            /**
             * Format: double
             * @description WGS-84 latitude.
             */
            lat_deg: number;
            /**
             * Format: double
             * @description WGS-84 longitude.
             */
            lon_deg: number;
        };
        /**
         * @description Role of a session.
         * @enum {string}
         */
        Role: "viewer" | "operator";
        /** @description Row of a vehicle in the fleet list. In a `roster` message, an absent field is unchanged and null is unknown. */
        RosterRow: {
            /**
             * Format: double
             * @description Airspeed, to 0.1 m/s.
             */
            airspeed_m_s?: number | null;
            alarm?: components["schemas"]["RosterText"] | null;
            /**
             * Format: double
             * @description Altitude above home, to 0.1 m.
             */
            alt_rel_home_m?: number | null;
            /**
             * Format: double
             * @description Remaining charge, 0 to 100.
             */
            battery_pct?: number | null;
            /**
             * Format: double
             * @description Heading of the nose, 0 to 360, whole degrees.
             */
            heading_deg?: number | null;
            /**
             * Format: double
             * @description Time when it was last heard, seconds on the station's clock, to 0.1 s.
             */
            heard_s?: number | null;
            /** @description Holder of control of a remote vehicle; null when there is none. */
            holder?: string | null;
            /**
             * Format: int32
             * @description Id of the vehicle in this API.
             */
            id: number;
            /** @description Whether it is armed. */
            is_armed?: boolean | null;
            /** @description Whether its mission has been completed. */
            is_complete?: boolean | null;
            /** @description Whether another vehicle with the same system id is heard, or another computer uses its name. */
            is_contested?: boolean | null;
            /** @description Whether an operator of this station is the holder of a remote vehicle. */
            is_held_here?: boolean | null;
            /** @description Whether it reports being on the ground. */
            is_on_ground?: boolean | null;
            /** @description Whether it hears us; null when unknown. */
            is_reached?: boolean | null;
            /** @description Whether it comes from a recording and takes no commands. */
            is_recorded?: boolean | null;
            /** @description Whether that is an operator of this station. */
            is_requested_here?: boolean | null;
            /** @description Whether its certificate was revoked, as far as this station knows. */
            is_revoked?: boolean | null;
            /**
             * Format: int32
             * @description Current mission item, counted from 1.
             */
            item?: number | null;
            /**
             * Format: int32
             * @description Number of items in its mission.
             */
            items?: number | null;
            /**
             * Format: double
             * @description WGS-84 latitude, to 0.1 m.
             */
            lat_deg?: number | null;
            /**
             * Format: double
             * @description WGS-84 longitude, to 0.1 m.
             */
            lon_deg?: number | null;
            /**
             * Format: double
             * @description Share of its frames that were lost, to 0.1 %; null for a remote vehicle.
             */
            loss_pct?: number | null;
            /**
             * Format: int32
             * @description `MAV_TYPE`; 1 is a fixed-wing plane.
             */
            mav_type?: number | null;
            /** @description Whether the mission on board may be a mixture of two. */
            may_be_mixed?: boolean | null;
            /** @description Flight mode by name. */
            mode?: string | null;
            /** @description Name of a vehicle in its fleet, or of the recording that it comes from; null for one on a link of this server. */
            remote_name?: string | null;
            /** @description Operator who asks for control of a remote vehicle; null when there is none. */
            requested_by?: string | null;
            /**
             * @description What the station on board of a remote vehicle reports of its links to the autopilot, in English, while the
             *     autopilot is silent; null when it is heard, and when the station on board is not heard either.
             */
            silence?: string | null;
            /**
             * Format: double
             * @description An alarm: distance between the position it flies to and the current item of its plan; null when there is no
             *     alarm.
             */
            target_off_m?: number | null;
        };
        /** @description A status text of a vehicle in the fleet list. */
        RosterText: {
            /**
             * Format: int32
             * @description `MAV_SEVERITY`: 0 emergency to 4 warning.
             */
            severity: number;
            /** @description The text. */
            text: string;
            /**
             * Format: double
             * @description Time of reception, seconds on the station's clock.
             */
            time_s: number;
        };
        /** @description A runway, usable in both directions; 20 m to 10 km long. */
        Runway: {
            /** @description One end. */
            begin: components["schemas"]["LatLon"];
            /** @description The other end. */
            end: components["schemas"]["LatLon"];
        };
        /** @description A sender in a recording. */
        Sender: {
            /**
             * Format: int32
             * @description `MAV_AUTOPILOT` of its heartbeats; null when there were none.
             */
            autopilot: number | null;
            /**
             * Format: int32
             * @description Component id.
             */
            component_id: number;
            /**
             * Format: int64
             * @description Number of frames.
             */
            frames: number;
            /**
             * Format: int32
             * @description `MAV_TYPE` of its heartbeats; null when there were none.
             */
            mav_type: number | null;
            /**
             * Format: int32
             * @description System id.
             */
            system_id: number;
        };
        /** @description Result of a separation check. */
        Separation: {
            /** @description Conflicts, earliest first; empty when all flights are separated. */
            conflicts: components["schemas"]["Conflict"][];
            /** @description Assumptions about each flight, in the order of the request. */
            flights: components["schemas"]["AssumedFlight"][];
            /** @description Limits in use. */
            limits: components["schemas"]["SeparationLimits"];
            /** @description Wind in which all flights were rehearsed. */
            wind: components["schemas"]["PlanWind"];
        };
        /** @description Limits of separation. */
        SeparationLimits: {
            /**
             * Format: double
             * @description Horizontal distance.
             */
            horizontal_m: number;
            /**
             * Format: double
             * @description Vertical distance.
             */
            vertical_m: number;
            /**
             * Format: double
             * @description Time.
             */
            window_s: number;
        };
        /** @description Planned flights whose separation is to be checked. */
        SeparationRequest: {
            /** @description Two to 32 flights. */
            flights: components["schemas"]["PlannedFlight"][];
            /**
             * Format: double
             * @description Horizontal limit of separation, 1 to 10,000; 100 when absent. Flights conflict below both limits.
             */
            horizontal_m?: number | null;
            /**
             * Format: double
             * @description Vertical limit of separation, 1 to 10,000; 30 when absent.
             */
            vertical_m?: number | null;
            wind?: components["schemas"]["PlanWind"] | null;
            /**
             * Format: double
             * @description Time by which each flight may be earlier or later than rehearsed, relative to another, 0 to 3,600; 10 when
             *     absent.
             */
            window_s?: number | null;
        };
        /** @description A serial port of the server's machine. */
        SerialPort: {
            /** @description Manufacturer and product, as a USB device says; null for another. */
            description: string | null;
            /** @description Its device: `/dev/ttyUSB0`, `COM3`. */
            device: string;
            /** @description Whether the server may open it: on Linux, its user must be in the port's group, mostly `dialout`. */
            is_allowed: boolean;
            /** @description Whether a program has locked it, the server included. Only Linux tells, and not every program locks. */
            is_in_use: boolean;
            /** @description A name that stays when the number of the device changes, in `/dev/serial/by-id`; null when there is none. */
            lasting_path: string | null;
            /**
             * Format: int32
             * @description Id of the link that is on it; null when there is none.
             */
            link: number | null;
            /**
             * Format: int32
             * @description Usual rate of such a port, baud: 115200 for an autopilot's own USB, 57600 for an adapter, behind which is mostly
             *     a radio, 921600 for a port of the machine's own.
             */
            usual_baud: number;
        };
        /**
         * @description Messages from the server. Telemetry, lists and states are the newest at the time of sending: a slow client misses
         *     intermediate ones. Texts and events are queued; when too many are waiting, the connection is closed with code 1013.
         */
        ServerMessage: (components["schemas"]["SessionInfo"] & {
            /**
             * Format: double
             * @description Time of sending, seconds on the station's clock.
             */
            time_s: number;
            /** @description Version of the server. */
            version: string;
        } & {
            /** @enum {string} */
            type: "hello";
        }) | {
            /** @enum {string} */
            type: "vehicles";
            /** @description Vehicles by id. */
            vehicles: components["schemas"]["VehicleSummary"][];
        } | {
            /** @description Vehicles whose telemetry this client is subscribed to, as in `vehicles`. */
            followed: components["schemas"]["VehicleSummary"][];
            /** @description Ids of vehicles that disappeared. */
            gone: number[];
            /** @description Changed rows, each with its changed fields; new rows with all fields. */
            rows: components["schemas"]["RosterRow"][];
            /**
             * Format: double
             * @description Time of these values, seconds on the station's clock.
             */
            time_s: number;
            /** @enum {string} */
            type: "roster";
        } | {
            /** @description The groups that changed. */
            groups: components["schemas"]["TelemetryGroups"];
            /** @description Mission progress; absent when unchanged. */
            progress?: components["schemas"]["MissionProgress"];
            /**
             * Format: double
             * @description Time of these values, seconds on the station's clock.
             */
            time_s: number;
            /** @enum {string} */
            type: "telemetry";
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } | {
            /**
             * Format: int64
             * @description Number of such messages since subscribing, including those that were not sent to the client.
             */
            count: number;
            /** @description The message. */
            message: components["schemas"]["RawMessage"];
            /** @enum {string} */
            type: "message";
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } | (components["schemas"]["Text"] & {
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } & {
            /** @enum {string} */
            type: "text";
        }) | {
            /** @description Details by name: `mode` and `from`, `landed`, or `item`; `distance_m` for `target_elsewhere`. */
            detail: {
                [key: string]: components["schemas"]["EventDetail"];
            };
            /**
             * @description `lost`, `regained`, `unreached` (it is heard, but does not hear us), `reached`, `rebooted`, `mode`, `armed`,
             *     `disarmed`, `landed`, `item`, `item_reached`, `mission_complete`, `target_elsewhere` (an alarm: it flies to
             *     a position other than its plan's), `target_as_planned`, `home`, `streams_fell_back`, `contested`,
             *     `uncontested`, `terrain_unknown` (it requests ground elevations that no map contains), `terrain_known`.
             */
            kind: string;
            /**
             * Format: double
             * @description Time of the event, seconds on the station's clock.
             */
            time_s: number;
            /** @enum {string} */
            type: "event";
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } | {
            /** @description Part of the plan. */
            kind: components["schemas"]["PlanKind"];
            /** @description New state. */
            state: components["schemas"]["PlanState"];
            /** @enum {string} */
            type: "plan_state";
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } | {
            /** @description The parameter. */
            param: components["schemas"]["Param"];
            /** @enum {string} */
            type: "param";
            /**
             * Format: int32
             * @description Id of the vehicle.
             */
            vehicle: number;
        } | (components["schemas"]["Assessment"] & {
            /**
             * Format: int64
             * @description Number of the request.
             */
            seq: number;
        } & {
            /** @enum {string} */
            type: "assessment";
        }) | (components["schemas"]["Way"] & {
            /**
             * Format: int64
             * @description Number of the request.
             */
            seq: number;
        } & {
            /** @enum {string} */
            type: "way";
        }) | (components["schemas"]["Operation"] & {
            /** @enum {string} */
            type: "operation";
        }) | {
            /** @description Links by id. */
            links: components["schemas"]["LinkInfo"][];
            /** @enum {string} */
            type: "links";
        } | {
            /** @description The fleets; empty when it is in none. */
            networks: components["schemas"]["FleetNetwork"][];
            /** @enum {string} */
            type: "networks";
        } | {
            /** @enum {string} */
            type: "maps";
        } | {
            /** @description Faults, the flight recorder's first; empty when there are none. */
            problems: components["schemas"]["StorageProblem"][];
            /** @enum {string} */
            type: "storage";
        } | {
            /** @description Browser or program that wrote it. */
            author: string;
            /**
             * Format: int64
             * @description The revision.
             */
            revision: number;
            /** @enum {string} */
            type: "draft";
        } | {
            /** @description Whether this session holds control. */
            has_control: boolean;
            /** @description Name of the session that holds control; null when there is none. */
            holder: string | null;
            /** @description Name of the session that requests control; null when there is none. */
            requested_by: string | null;
            /** @enum {string} */
            type: "control";
        } | {
            /** @description Machine-readable cause. */
            cause: components["schemas"]["Cause"];
            /** @description Why, in English. */
            detail: string;
            /**
             * Format: int64
             * @description Number of the request about a plan; absent for other messages.
             */
            seq?: number;
            /** @enum {string} */
            type: "error";
        };
        /** @description SERVO_OUTPUT_RAW of outputs 1 to 16: the signals to the actuators. */
        ServoOutputs: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description Pulse lengths of outputs 1 to 16; null for an output that is off. */
            pulse_us: (number | null)[];
        };
        /** @description A session, as its owner sees it. The secret that authenticates it is in the cookie. */
        SessionInfo: {
            /** @description Whether the session holds control. */
            has_control: boolean;
            /** @description Name of the session that holds control; null when there is none. */
            holder: string | null;
            /** @description Display name. */
            name: string;
            /** @description Name of the session that requests control; null when there is none. */
            requested_by: string | null;
            /** @description Role of the session. */
            role: components["schemas"]["Role"];
            /** @description Public id of the session. */
            session: string;
        };
        /** @description Switches the station's heartbeat. */
        SetHeartbeat: {
            /** @description Whether to send it. */
            enabled: boolean;
        };
        /**
         * @description Action on a vehicle's key.
         * @enum {string}
         */
        SigningAct: "set_up" | "rotate" | "remove";
        /** @description Signing state of a vehicle; counters start with the server. */
        SigningInfo: {
            /** @description Name of the key in use with the vehicle; null when there is none. */
            key: string | null;
            /** @description Whether that key is missing on this machine; all frames of the vehicle are refused then. */
            key_missing: boolean;
            /** @description Whether its link accepts unsigned frames: USB, loopback, or configured so. */
            link_accepts_unsigned: boolean;
            /** @description Whether unsigned frames of the vehicle are refused. */
            must_sign: boolean;
            /**
             * Format: double
             * @description Time since the newest refused frame.
             */
            refused_age_s: number | null;
            /**
             * Format: int64
             * @description Refused: timestamp in the future.
             */
            refused_future: number;
            /**
             * Format: int64
             * @description Refused: first frame of its stream, older than a minute.
             */
            refused_old: number;
            /**
             * Format: int64
             * @description Refused: not newer than the last accepted frame.
             */
            refused_replayed: number;
            /**
             * Format: int64
             * @description Refused: unsigned.
             */
            refused_unsigned: number;
            /**
             * Format: int64
             * @description Refused: signed with another key, or altered in transit.
             */
            refused_wrong_key: number;
            /** @description Names of keys that were sent to the vehicle but that it has not used yet. */
            unproven: string[];
            /**
             * Format: int64
             * @description Unsigned frames that were accepted.
             */
            unsigned_accepted: number;
            /**
             * Format: int64
             * @description Frames with a valid signature.
             */
            verified: number;
            /**
             * Format: double
             * @description Time since the newest verified frame.
             */
            verified_age_s: number | null;
        };
        /**
         * @description Which speed DO_CHANGE_SPEED sets.
         * @enum {string}
         */
        SpeedKind: "airspeed" | "groundspeed";
        /** @description Result of many flights of one plan. Ranges contain nine flights in ten. */
        Spread: {
            battery_left_pct: components["schemas"]["SpreadRange"] | null;
            /** @description Number of all flights that leave less than the reserve; null when it cannot be computed. */
            below_reserve: number | null;
            /** @description Corridor of nine flights in ten, with a point every five seconds. */
            corridor: components["schemas"]["Corridor"];
            /** @description Duration of the flights that ended like the expected one, seconds. */
            duration_s: components["schemas"]["SpreadRange"];
            /** @description Number of flights by ending, most frequent first. */
            endings: components["schemas"]["EndingCount"][];
            energy_wh: components["schemas"]["SpreadRange"] | null;
            /** @description Number of flights. */
            runs: number;
            touch_down_m: components["schemas"]["SpreadRange"] | null;
        };
        /** @description Least, median and most of nine in ten flights. */
        SpreadRange: {
            /**
             * Format: double
             * @description One flight in twenty has more.
             */
            high: number;
            /**
             * Format: double
             * @description One flight in twenty has less.
             */
            low: number;
            /**
             * Format: double
             * @description Half of them have less.
             */
            median: number;
        };
        /** @description A plan to be flown many times under uncertainty. */
        SpreadRequest: {
            /** @description Uncertainty of the wind and the plane. */
            doubts?: components["schemas"]["Doubts"];
            /** @description The plan; without a home, the vehicle's home is used. */
            plan: components["schemas"]["Plan"];
            /** @description Plane, in place of the vehicle's. */
            profile?: components["schemas"]["PlaneProfile"];
            /** @description Number of flights, 1 to 1000; 200 by default. */
            runs?: number | null;
            /**
             * Format: int64
             * @description Random seed; the same seed gives the same result. 0 by default.
             */
            seed?: number;
            /**
             * Format: int32
             * @description Vehicle that is to fly it.
             */
            vehicle?: number | null;
            wind?: components["schemas"]["PlanWind"] | null;
        };
        /**
         * @description Kinds of data on the server's disk.
         * @enum {string}
         */
        StorageClass: "telemetry" | "maps" | "missions" | "video" | "draft" | "tokens" | "signing" | "signing_times";
        /** @description Kind of a storage fault. */
        StorageFault: {
            /**
             * Format: int64
             * @description Megabytes that must stay free.
             */
            floor_mb: number;
            /**
             * Format: int64
             * @description Free megabytes.
             */
            free_mb: number;
            /** @enum {string} */
            kind: "low_space";
        } | {
            /** @enum {string} */
            kind: "unwritable";
            /** @description Message of the operating system, in English. */
            reason: string;
        } | {
            /** @enum {string} */
            kind: "unreadable";
            /** @description The reason, in English. */
            reason: string;
        } | {
            /** @enum {string} */
            kind: "stalled";
        } | {
            /** @enum {string} */
            kind: "set_aside";
            /** @description New name of the damaged file. */
            name: string;
        } | {
            /** @enum {string} */
            kind: "ended";
            /** @description The reason, in English. */
            reason: string;
        };
        /** @description A storage fault: data that is not being kept. */
        StorageProblem: {
            /** @description The fault. */
            fault: components["schemas"]["StorageFault"];
            /** @description Name of the camera or map source; null for data that exists once. */
            name: string | null;
            /**
             * Format: double
             * @description Time since which it is known, seconds on the station's clock.
             */
            since_s: number;
            /** @description Description in English. */
            text: string;
            /** @description Kind of data. */
            what: components["schemas"]["StorageClass"];
        };
        /** @description A survey, ready to be inserted in a mission, with its rehearsal. */
        Survey: {
            /**
             * Format: double
             * @description Size of the area or corridor.
             */
            area_m2: number;
            /** @description Cautions for the pilot. */
            cautions: components["schemas"]["SurveyCaution"][];
            /** @description The survey as a complex item of QGroundControl, to be put in the plan's `complex_items` along with its items. */
            complex_item: components["schemas"]["ComplexItem"];
            /**
             * Format: double
             * @description Course of the first line, from true north.
             */
            course_deg: number;
            /** @description What determined the course. */
            course_from: components["schemas"]["LineCourse"];
            /**
             * Format: double
             * @description Largest crab angle on the lines (between heading and course).
             */
            crab_deg: number;
            /**
             * Format: double
             * @description Duration in this wind.
             */
            duration_s: number;
            /** @description Its rehearsal. */
            flown: components["schemas"]["FlownSurvey"];
            /**
             * Format: double
             * @description Width of an image on the ground across the track; null without a camera.
             */
            footprint_across_m: number | null;
            /**
             * Format: double
             * @description Length of an image on the ground along the track; null without a camera.
             */
            footprint_along_m: number | null;
            /**
             * Format: double
             * @description Highest ground speed on the lines.
             */
            groundspeed_max_m_s: number;
            /**
             * Format: double
             * @description Lowest ground speed on the lines.
             */
            groundspeed_min_m_s: number;
            /**
             * Format: double
             * @description Ground sample distance; null without a camera.
             */
            gsd_m: number | null;
            /**
             * Format: double
             * @description Height above the ground.
             */
            height_m: number;
            /** @description Waypoints and camera commands; the first waypoint leads to the first line, the last one away from the last line. */
            items: components["schemas"]["PlanItem"][];
            /**
             * Format: double
             * @description Straight distance before the first image of a line.
             */
            lead_in_m: number;
            /**
             * Format: double
             * @description Straight distance after the last image of a line.
             */
            lead_out_m: number;
            /**
             * Format: double
             * @description Total length flown.
             */
            length_m: number;
            /**
             * Format: double
             * @description Total length photographed.
             */
            line_m: number;
            /** @description Lines photographed without interruption, in the order flown. */
            lines: components["schemas"]["LatLon"][][];
            next_entry: components["schemas"]["LatLon"] | null;
            /**
             * Format: int64
             * @description Number of images.
             */
            photos: number;
            /**
             * Format: double
             * @description Distance between lines.
             */
            spacing_m: number;
            /**
             * Format: double
             * @description Distance between images; null when the camera is not triggered.
             */
            trigger_m: number | null;
            /**
             * Format: double
             * @description Radius of the turns.
             */
            turn_radius_m: number;
        };
        /** @description A caution for the pilot before a survey is flown. */
        SurveyCaution: {
            /** @description `ground-not-known`, `camera-too-slow`, `along-wind`, `tight-turns` or `gaps`. */
            code: string;
            /** @description The caution in English. */
            message: string;
        };
        /** @description An uncovered place. */
        SurveyHole: {
            /**
             * Format: double
             * @description Its size.
             */
            area_m2: number;
            /** @description Its centre. */
            at: components["schemas"]["LatLon"];
        };
        /**
         * @description Design request for a survey. It needs a camera and either `gsd_m` or `height_m`; or, without a camera, `height_m`
         *     and `spacing_m`.
         */
        SurveyRequest: {
            /**
             * Format: double
             * @description Airspeed, set by a mission item, 5 to 60; the plane's cruise airspeed by default.
             */
            airspeed_m_s?: number | null;
            camera?: components["schemas"]["Camera"] | null;
            coming_from?: components["schemas"]["LatLon"] | null;
            /**
             * Format: double
             * @description Course of an area's lines, from true north; by default across the wind, or along the area in calm air.
             */
            course_deg?: number | null;
            /**
             * Format: double
             * @description Overlap with the next image on the line, 0 to 0.95; 0.75 by default.
             */
            front_overlap?: number | null;
            /**
             * Format: double
             * @description Ground elevation above home; 0 when unknown.
             */
            ground_rel_home_m?: number | null;
            /**
             * Format: double
             * @description Ground sample distance, 0.0005 to 10.
             */
            gsd_m?: number | null;
            /**
             * Format: double
             * @description Height above the ground, 5 to 10,000.
             */
            height_m?: number | null;
            home?: components["schemas"]["Home"] | null;
            /** @description Whether altitudes are relative to the terrain, which must be known to the vehicle, and not to home. */
            is_above_terrain?: boolean;
            /** @description Whether the wide side of the image is across the track; true by default. */
            is_landscape?: boolean;
            /**
             * Format: double
             * @description Straight distance before a line; by default as much as the plane needs to settle on it.
             */
            lead_in_m?: number | null;
            /**
             * Format: double
             * @description Distance by which images extend beyond the edge; by default as much as keeps the overlap up to the edge.
             */
            margin_m?: number | null;
            /** @description Corners of the area in order, 3 to 1,000; or points of the line of a corridor, 2 to 1,000. */
            places: components["schemas"]["LatLon"][];
            /**
             * Format: double
             * @description Overlap with the images of the next line, 0 to 0.95; 0.65 by default.
             */
            side_overlap?: number | null;
            /**
             * Format: double
             * @description Distance between lines, in place of the one derived from the overlap.
             */
            spacing_m?: number | null;
            /**
             * Format: double
             * @description Distance between images, in place of the one derived from the overlap.
             */
            trigger_m?: number | null;
            /**
             * Format: int32
             * @description Vehicle that is to fly it, whose parameters are used; a default ArduPlane when absent.
             */
            vehicle?: number | null;
            /**
             * Format: double
             * @description Width of a corridor, 0 to 5,000 (0: a single pass); absent or null for an area.
             */
            width_m?: number | null;
            wind?: components["schemas"]["PlanWind"] | null;
        };
        /** @description SYS_STATUS: sensors and power at a glance. */
        SysStatus: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Charge left, 0 to 100 %.
             */
            battery_remaining_pct: number | null;
            /**
             * Format: double
             * @description Battery current, discharge positive.
             */
            current_a: number | null;
            /**
             * Format: double
             * @description Messages lost on their way to the vehicle, 0 to 100 %.
             */
            drop_rate_pct: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description Whether the vehicle's pre-arm checks pass; null when not reported. */
            is_ready_to_arm: boolean | null;
            /**
             * Format: double
             * @description Processor load, 0 to 100 %.
             */
            load_pct: number | null;
            /** @description Sensors in use that are unhealthy. */
            unhealthy_sensors: string[];
            /**
             * Format: double
             * @description Battery voltage.
             */
            voltage_v: number | null;
        };
        /** @description SYSTEM_TIME: the vehicle's clocks. */
        SystemTime: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: int32
             * @description Time since the vehicle booted.
             */
            boot_ms: number;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: int64
             * @description UTC of the vehicle when the message was sent, microseconds since 1970; null before it knows the date.
             */
            utc_us: number | null;
        };
        /**
         * @description The newest values by group. A group that was never heard is absent. In a WebSocket message a group that did not
         *     change is absent, and one that the vehicle's restart made void is null.
         */
        TelemetryGroups: {
            airspeed?: components["schemas"]["AirspeedSensor"] | null;
            attitude?: components["schemas"]["Attitude"] | null;
            /** @description The batteries heard so far. */
            batteries?: components["schemas"]["Battery"][];
            ekf?: components["schemas"]["Ekf"] | null;
            engine?: components["schemas"]["Engine"] | null;
            extended?: components["schemas"]["ExtendedState"] | null;
            fence?: components["schemas"]["FenceStatus"] | null;
            gps?: components["schemas"]["Gps"] | null;
            heartbeat?: components["schemas"]["Heartbeat"] | null;
            home?: components["schemas"]["HomePosition"] | null;
            hud?: components["schemas"]["Hud"] | null;
            imu?: components["schemas"]["Imu"] | null;
            /** @description Inertial sensors 1 to 3. */
            imus?: (components["schemas"]["Imu"] | null)[];
            mission?: components["schemas"]["MissionCurrent"] | null;
            nav?: components["schemas"]["NavController"] | null;
            position?: components["schemas"]["Position"] | null;
            pressure?: components["schemas"]["Pressure"] | null;
            radio?: components["schemas"]["Radio"] | null;
            rc?: components["schemas"]["RcChannels"] | null;
            servos?: components["schemas"]["ServoOutputs"] | null;
            sys_status?: components["schemas"]["SysStatus"] | null;
            system_time?: components["schemas"]["SystemTime"] | null;
            terrain?: components["schemas"]["TerrainReport"] | null;
            version?: components["schemas"]["AutopilotVersion"] | null;
            vibration?: components["schemas"]["Vibration"] | null;
            wind?: components["schemas"]["Wind"] | null;
        };
        /** @description TERRAIN_REPORT: the vehicle's terrain data. */
        TerrainReport: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Altitude of the vehicle above that terrain.
             */
            alt_terrain_m: number | null;
            /**
             * Format: double
             * @description Ground above mean sea level under the vehicle (or where TERRAIN_CHECK asked); null as long as it does not
             *     know it.
             */
            ground_amsl_m: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: int32
             * @description Blocks that it holds in memory.
             */
            loaded: number;
            /**
             * Format: int32
             * @description Blocks of 4 × 4 altitudes that it waits for.
             */
            pending: number;
        };
        /** @description A status text from the vehicle (STATUSTEXT). */
        Text: {
            /**
             * Format: int32
             * @description `MAV_SEVERITY`: 0 emergency to 7 debug.
             */
            severity: number;
            /** @description The text. */
            text: string;
            /**
             * Format: double
             * @description Time of reception, seconds on the station's clock; of a replay, the position in its recording.
             */
            time_s: number;
            /**
             * Format: double
             * @description Of a replay, the time at which it was recorded, seconds since 1970; null when unknown, and for other vehicles.
             */
            unix_s: number | null;
        };
        /**
         * @description Kind of a resource that a request named and that does not exist.
         * @enum {string}
         */
        Thing: "path" | "file" | "vehicle" | "link" | "operation" | "recording" | "camera" | "message" | "command" | "area" | "replay";
        /**
         * @description What fails in flight, or is asked for.
         * @enum {string}
         */
        Trigger: "return-asked" | "link-lost" | "radio-lost" | "battery-low" | "battery-critical" | "go-around" | "engine-stopped";
        /** @description A mission as it is flown, in calm air at the speeds that are known. */
        Trip: {
            /**
             * Format: double
             * @description Length of the way over ground, circles included, metres; up to the circle without end where it ends in one. Null
             *     when it never ends, needs a home that is unknown, or holds an item of unknown length.
             */
            distance_m: number | null;
            /** @description How it ends. */
            end: components["schemas"]["TripEnd"];
            /**
             * @description Whether the distance depends on values that are not in the plan: a speed, a climb rate, the vehicle's own
             *     radius.
             */
            is_estimate: boolean;
            /**
             * Format: double
             * @description Time for that, seconds; null when the distance is, or without a speed.
             */
            time_s: number | null;
        };
        /**
         * @description How a mission ends.
         * @enum {string}
         */
        TripEnd: "end" | "unlimited" | "endless";
        /** @description An item whose altitude could not be converted. */
        Unconverted: {
            /** @description Number of the item, counted from 1. */
            item: number;
            /** @description The unknown reference level. */
            level: components["schemas"]["UnknownLevel"];
        };
        /**
         * @description A level that is not known, so that no height can be counted from it, or from another.
         * @enum {string}
         */
        UnknownLevel: "home" | "ground" | "frame";
        /** @description Who has control of a vehicle. */
        VehicleControl: {
            /** @description Name of the operator who has control, after that of the ground station; null when nobody has it. */
            holder: string | null;
            /** @description Whether that is an operator of this station. */
            is_held_here: boolean;
            /** @description Whether that is an operator of this station. */
            is_requested_here: boolean;
            /** @description Name of the operator who asks for control; null when there is none. */
            requested_by: string | null;
        };
        /** @description Data with which a vehicle's plans are rehearsed. */
        VehicleProfile: {
            /** @description Airframe according to its parameters; its power is measured in flight, as far as the flight was followed. */
            airframe: components["schemas"]["Airframe"];
            /**
             * Format: double
             * @description Charge of a full battery, mAh; null when unknown.
             */
            capacity_mah: number | null;
            /**
             * Format: double
             * @description Present charge, percent of the capacity; 100 when unknown.
             */
            charge_pct: number;
            /** @description Whether its parameters were read; otherwise a default ArduPlane is assumed. */
            knows_parameters: boolean;
            learned: components["schemas"]["LearnedPlane"] | null;
            /**
             * Format: double
             * @description Charge that should remain after landing, percent of the capacity.
             */
            reserve_pct: number;
            /**
             * Format: double
             * @description Present battery voltage; null when unknown.
             */
            voltage_v: number | null;
        };
        /** @description State of a vehicle. */
        VehicleState: {
            /** @description Whether it flies the arcs of `NAV_ARC_WAYPOINT`; a plane passes straight over such items. */
            flies_arcs: boolean;
            link: components["schemas"]["LinkInfo"] | null;
            /** @description Names of its flight modes. */
            mode_names: string[];
            /** @description States of the plans on board. */
            plan_states: components["schemas"]["PlanStates"];
            /** @description Mission progress. */
            progress: components["schemas"]["MissionProgress"];
            /**
             * Format: int32
             * @description Id of the vehicle in this API: the MAVLink system id of one on a link, 256 to 65,535 for a remote or replayed one.
             */
            system_id: number;
            /** @description Newest telemetry values by group. */
            telemetry: components["schemas"]["TelemetryGroups"];
            /**
             * Format: double
             * @description Time of this snapshot, seconds on the station's clock.
             */
            time_s: number;
        };
        /** @description Summary of a vehicle. */
        VehicleSummary: {
            /**
             * Format: double
             * @description Time since it was last heard; stale after 3.5 s, lost after 5 s.
             */
            age_s: number | null;
            /**
             * Format: int32
             * @description `MAV_AUTOPILOT`; 3 is ArduPilot.
             */
            autopilot: number | null;
            control: components["schemas"]["VehicleControl"] | null;
            /** @description Flight characteristics according to its parameters, as far as they were read. */
            flight_parameters: components["schemas"]["FlightParameters"];
            /** @description Whether it is armed. */
            is_armed: boolean | null;
            /**
             * @description Whether it hears us: false when it is heard but answers nothing of ours, so that the link works in one direction
             *     only; null when unknown.
             */
            is_reached: boolean | null;
            /** @description Whether it comes from a recording and takes no commands: a replay, or a link that plays one. */
            is_recorded: boolean;
            /** @description Whether the certificate of a remote vehicle was revoked, as far as this station knows. */
            is_revoked: boolean;
            /** @description Whether it requests ground elevations at positions that no map of this server contains. */
            lacks_terrain: boolean;
            /**
             * Format: int32
             * @description Id of the link over which it is reached.
             */
            link: number | null;
            /**
             * Format: double
             * @description Share of its frames that were lost, percent.
             */
            loss_pct: number | null;
            /**
             * Format: int32
             * @description `MAV_TYPE`; 1 is a fixed-wing plane.
             */
            mav_type: number | null;
            /** @description Flight mode by name. */
            mode: string | null;
            /**
             * @description Name of a vehicle that is not on a link of this server: in its fleet, where a station on board is asked for it, or of
             *     the recording that it comes from.
             */
            remote_name: string | null;
            replay: components["schemas"]["Replay"] | null;
            /**
             * @description Where another vehicle with the same system id is heard, to which nothing is sent; for a remote vehicle, another
             *     computer with the same name: orders go only to the one heard first. Null when there is none.
             */
            rival: string | null;
            /**
             * Format: double
             * @description Round-trip time of the newest TIMESYNC exchange.
             */
            round_trip_ms: number | null;
            /**
             * @description What the station on board of a remote vehicle reports of its links to the autopilot, in English, while the
             *     autopilot is silent; null when it is heard, and when the station on board is not heard either.
             */
            silence: string | null;
            /**
             * Format: int32
             * @description Id of the vehicle in this API: the MAVLink system id of one on a link, 256 to 65,535 for a remote or replayed one.
             */
            system_id: number;
        };
        /**
         * @description How a landing suits.
         * @enum {string}
         */
        Verdict: "good" | "doubtful" | "bad";
        /** @description VIBRATION of the airframe, measured by the accelerometers. */
        Vibration: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /** @description Clipping events of each accelerometer since boot. */
            clipping: number[];
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /** @description Levels along body x, y, z. */
            vibration_m_s2: (number | null)[];
        };
        /**
         * @description Codec of a camera's images.
         * @enum {string}
         */
        VideoCodec: "h264" | "jpeg";
        /**
         * @description Requirement on a value that is to be sent.
         * @enum {string}
         */
        WantedValue: "finite" | "latitude" | "longitude" | "height" | "whole-number" | "frame";
        /** @description Route of a mission, as drawn on the map. */
        Way: {
            /** @description How the mission ends. */
            end: components["schemas"]["MissionEnd"];
            /** @description Whether more terrain is still being loaded: repeat the request a moment later. */
            is_ground_pending: boolean;
            /** @description Jumps between them. */
            jumps: components["schemas"]["WayJump"][];
            /** @description Altitude profile along the route, with the terrain below as far as it is loaded. */
            profile: components["schemas"]["Profile"];
            /** @description Items that the vehicle flies to, in order. */
            stops: components["schemas"]["WayStop"][];
        };
        /**
         * @description Until when the plane circles.
         * @enum {string}
         */
        WayCircling: "turns" | "time" | "height" | "unlimited";
        /** @description The descent of an approach. */
        WayDescent: {
            /**
             * Format: double
             * @description Height lost, metres.
             */
            drop_m: number;
            /** @description Whether it is steeper than [`STEEP_SLOPE`], or does not lead down. */
            is_doubtful: boolean;
        };
        /** @description Where a jump leads. */
        WayJump: {
            /** @description The jump, counted from 1. */
            item: number;
            /** @description The item that it leads to. */
            to_item: number;
        };
        /** @description The line from one place to the next. */
        WayLeg: {
            /**
             * Format: double
             * @description Course at its beginning from place to place, degrees from true north.
             */
            course_deg: number;
            descent: components["schemas"]["WayDescent"] | null;
            /** @description The item that it comes from, counted from 1; null for home. */
            from_item: number | null;
            /** @description Its kind. */
            kind: components["schemas"]["WayLegKind"];
            /** @description The line that is flown, degrees: at a circle it begins or ends on it. */
            lat_deg: number[];
            /**
             * Format: double
             * @description From place to place, metres: of a tangent the straight line, of an arc the arc.
             */
            length_m: number;
            /** @description The same points' longitudes. */
            lon_deg: number[];
        };
        /**
         * @description Kind of leg.
         * @enum {string}
         */
        WayLegKind: "takeoff" | "flown" | "approach" | "return";
        /** @description The circle at an item. */
        WayLoiter: {
            /**
             * Format: double
             * @description Of a circle to a height: how much of the change is done when it begins, 0 to 1; 1 for the others.
             */
            changed_before: number;
            /** @description Its sense. */
            is_clockwise: boolean;
            /** @description Whether that depends on values that are not in the plan: a speed, a climb rate, the vehicle's own radius. */
            is_estimate: boolean;
            /** @description Whether the radius is the item's own; false where the vehicle flies its usual one (`WP_LOITER_RAD`). */
            is_own_radius: boolean;
            /** @description Until when. */
            kind: components["schemas"]["WayCircling"];
            /**
             * Format: double
             * @description Way in it, metres; null when it has no end or is not known.
             */
            length_m: number | null;
            /**
             * Format: double
             * @description Radius, metres.
             */
            radius_m: number;
            /**
             * Format: double
             * @description Time in it, seconds; null likewise.
             */
            time_s: number | null;
        };
        /** @description A plan whose route is wanted. */
        WayRequest: {
            /**
             * Format: double
             * @description Clearance to keep above the ground, 0 to 1000; 30 by default.
             */
            clearance_m?: number | null;
            /** @description The plan. */
            plan: components["schemas"]["Plan"];
            /**
             * Format: int32
             * @description Vehicle that is to fly it; a default ArduPlane when absent.
             */
            vehicle?: number | null;
        };
        /** @description An item that the vehicle flies to. */
        WayStop: {
            /** @description It, counted from 1. */
            item: number;
            leg: components["schemas"]["WayLeg"] | null;
            loiter: components["schemas"]["WayLoiter"] | null;
        };
        /** @description A contingency: one event and its consequences. */
        WhatIf: {
            /** @description Decisions of the vehicle in order of time; empty when its settings do not act on the event. */
            decisions: components["schemas"]["Decision"][];
            flown: components["schemas"]["RehearsedFlight"] | null;
            /** @description Final reaction. */
            reaction: components["schemas"]["Reaction"];
            /** @description The event. */
            trigger: components["schemas"]["Trigger"];
        };
        /** @description A contingency at a time in a plan or in the present flight. */
        WhatIfRequest: {
            /**
             * Format: double
             * @description Time in the plan, seconds since the beginning of the rehearsed flight.
             */
            at_s?: number | null;
            begun?: components["schemas"]["Beginning"] | null;
            plan?: components["schemas"]["Plan"] | null;
            /** @description Plane, in place of the vehicle's. */
            profile?: components["schemas"]["PlaneProfile"];
            /** @description Events to examine; all when absent. */
            triggers?: components["schemas"]["Trigger"][] | null;
            /**
             * Format: int32
             * @description Vehicle that is to fly it; the plane is modelled by its parameters, as far as they were read.
             */
            vehicle?: number | null;
            wind?: components["schemas"]["PlanWind"] | null;
        };
        /** @description Contingencies at a time in a flight. */
        WhatIfs: {
            ahead: components["schemas"]["RehearsedFlight"] | null;
            at: components["schemas"]["LatLon"] | null;
            /**
             * Format: double
             * @description The time, seconds since the beginning of the rehearsed flight; 0 is now for the vehicle's present flight.
             */
            at_s: number;
            /** @description Area that can be reached without thrust, as a ring of positions clockwise from north. */
            glide_range: components["schemas"]["LatLon"][];
            /**
             * Format: double
             * @description Altitude above home at that time, metres.
             */
            height_m: number;
            /**
             * @description Whether it is known how much of the present circle has been flown. If not, for example when the station was
             *     started while the vehicle circled, `ahead` includes the whole circle, and whether the flight is late is unknown
             *     until the vehicle proceeds to the next item.
             */
            is_circle_known: boolean;
            now: components["schemas"]["FlightNow"] | null;
            outlook: components["schemas"]["Outlook"] | null;
            /** @description One result for each requested event. */
            what_ifs: components["schemas"]["WhatIf"][];
        };
        /** @description WIND (ArduPilot) or WIND_COV: the autopilot's estimate. */
        Wind: {
            /**
             * Format: double
             * @description How old the values are, seconds.
             */
            age_s: number;
            /**
             * Format: double
             * @description Direction that the wind comes from, 0 to 360.
             */
            from_deg: number | null;
            /** @description Whether the message held a value that cannot be; such fields are null. */
            has_invalid: boolean;
            /**
             * Format: double
             * @description Vertical speed, down positive.
             */
            speed_down_m_s: number | null;
            /**
             * Format: double
             * @description Horizontal speed.
             */
            speed_m_s: number | null;
        };
        /**
         * @description Shape of a fence zone.
         * @enum {string}
         */
        ZoneShape: "polygon" | "circle";
    };
    responses: never;
    parameters: never;
    requestBodies: never;
    headers: never;
    pathItems: never;
}
export type $defs = Record<string, never>;
export interface operations {
    list_cameras: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CameraInfo"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_camera: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The camera's name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CameraInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    start_recording: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The camera's name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CameraInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    stop_recording: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The camera's name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CameraInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    snapshot: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The camera's name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/jpeg": number[];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    keep_snapshot: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The camera's name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/jpeg": number[];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    watch: {
        parameters: {
            query?: {
                /** @description `h264` if the viewer can decode it; otherwise, all images are sent as JPEG. */
                accept?: string;
            };
            header?: never;
            path: {
                /** @description The camera's name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            /** @description The WebSocket */
            101: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_commands: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CommandInfo"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    keep_control: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": components["schemas"]["DeclinedRequest"] | null;
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    release_control: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    request_control: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    take_control: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_draft: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlanDrafts"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_draft: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewPlanDraft"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlanDraft"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_draft: {
        parameters: {
            query: {
                /** @description Revision of the draft. */
                base: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_elevation: {
        parameters: {
            query: {
                /** @description WGS-84 latitude. */
                lat_deg: number;
                /** @description WGS-84 longitude. */
                lon_deg: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ElevationPoint"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_elevations: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ElevationRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Elevations"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_elevation_profile: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ProfileRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ElevationProfile"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_footage: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Footage"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_footage: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description File name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "video/x-matroska": number[];
                };
            };
            /** @description The requested range */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_footage: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description File name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    set_heartbeat: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SetHeartbeat"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_history: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["AircraftHistory"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_history_file: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The fleet, or `_board` */
                place: string;
                /** @description File name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": number[];
                };
            };
            /** @description The requested range */
            206: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    info: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Info"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_links: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["LinkInfo"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    open_link: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewLink"];
            };
        };
        responses: {
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["LinkInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    close_link: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The link's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_map_areas: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapArea"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    add_map_area: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["AreaRequest"];
            };
        };
        responses: {
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapArea"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    estimate_map_area: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["AreaRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapAreaEstimate"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    import_map_area: {
        parameters: {
            query: {
                /** @description Id of the source to which the tiles belong. */
                source: string;
                /** @description Display name of the area; the file's own name when empty. */
                name?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": number[];
            };
        };
        responses: {
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapArea"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_map_area: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the area */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapArea"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    remove_map_area: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the area */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    export_map_area: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the area */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/x-sqlite3": number[];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    pause_map_area: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the area */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapArea"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    resume_map_area: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the area */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapArea"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    ask_map_capabilities: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["CapabilitiesRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapCapabilities"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_map_config: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapConfiguration"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_map_files: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapFileInfo"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    take_map_file: {
        parameters: {
            query: {
                /** @description File name; its extension determines the type. */
                name: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": number[];
            };
        };
        responses: {
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapFileTaken"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_map_kinds: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapKind"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    order_map_sources: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["MapOrder"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapSources"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_map_presets: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapPreset"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_map_sources: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapSources"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    put_map_source: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the source */
                id: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["MapSourceSettings"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapSource"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    delete_map_source: {
        parameters: {
            query?: {
                /** @description Whether to delete everything cached of it, including offline areas. */
                cache?: boolean;
            };
            header?: never;
            path: {
                /** @description Id of the source */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_map_attribution: {
        parameters: {
            query: {
                /** @description Left edge. */
                west_deg: number;
                /** @description Lower edge. */
                south_deg: number;
                /** @description Right edge. */
                east_deg: number;
                /** @description Upper edge. */
                north_deg: number;
                /** @description Zoom level of Web Mercator. */
                zoom: number;
            };
            header?: never;
            path: {
                /** @description Id of the source */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapAttributions"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    clear_map_cache: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the source */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    check_map_source: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the source */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["MapSourceState"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_map_image: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the source */
                id: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/*": number[];
                };
            };
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_networks: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["FleetNetwork"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_operations: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_operation: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the operation */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    cancel_operation: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of the operation */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    format_params: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["FileParam"][];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "text/plain": string;
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    parse_params: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": number[];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["FileParam"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    cameras: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["NamedCamera"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    check: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["PlanCheck"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Finding"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    complex_parts: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Plan"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ComplexPart"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    plan_fixes: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RehearsalRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["FindingFix"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    format_plan: {
        parameters: {
            query: {
                /** @description Format, named by its file extension. */
                as: "plan" | "waypoints" | "kml" | "kmz" | "geojson" | "gpx" | "csv";
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Plan"];
            };
        };
        responses: {
            200: {
                headers: {
                    /** @description JSON: a list of `PlanFileNote` */
                    "Vencejo-Notes"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": number[];
                    "text/plain": number[];
                    "text/csv": number[];
                    "application/vnd.google-earth.kml+xml": number[];
                    "application/vnd.google-earth.kmz": number[];
                    "application/geo+json": number[];
                    "application/gpx+xml": number[];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    counted_from: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["FrameChange"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["CountedItems"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    landing: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["LandingRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Landing"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    alternatives: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["LandingRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["LandingAlternative"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    moved_landing: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["LandingMove"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Landing"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    learn: {
        parameters: {
            query?: {
                /** @description Name of a recording on the server's disk, in place of a body. */
                recording?: string;
                /** @description Vehicle whose parameters, as far as they were read, describe the plane. */
                vehicle?: number;
                /** @description System id of the vehicle in the recording; the first that reports its position when absent. */
                system?: number;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": number[];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["LearnedPlane"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    parse: {
        parameters: {
            query?: {
                /** @description The file name, for messages only: the content determines the format. */
                name?: string;
            };
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/octet-stream": number[];
            };
        };
        responses: {
            200: {
                headers: {
                    /** @description JSON: a list of `PlanFileNote` */
                    "Vencejo-Notes"?: string;
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Plan"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    rehearse: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RehearsalRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Rehearsal"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    rehearse_many: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SpreadRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Spread"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    separate: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SeparationRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Separation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    survey: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["SurveyRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Survey"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    way: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["WayRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Way"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    what_if: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["WhatIfRequest"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["WhatIfs"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    recorder: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Recorder"] | null;
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_recordings: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Recording"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_recording: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description File name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/octet-stream": number[];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    keep: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description File name */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["KeepRecording"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    summarize: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description File name */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RecordingSummary"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_replays: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Replay"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    open_replay: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewReplay"];
            };
        };
        responses: {
            201: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Replay"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    close_replay: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The replay's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    change_replay: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The replay's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ReplayChange"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Replay"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_marks: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The replay's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["ReplayMark"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_serial_ports: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SerialPort"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_session: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    open_session: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": components["schemas"]["NewSession"] | null;
            };
        };
        responses: {
            /** @description Sets the session's cookie */
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SessionInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    close_session: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    storage_problems: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["StorageProblem"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    tile: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description Id of a source */
                source: string;
                /** @description Level of its grid */
                z: number;
                /** @description Column */
                x: number;
                /** @description Row */
                y: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "image/*": number[];
                };
            };
            304: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_vehicles: {
        parameters: {
            query?: never;
            header?: never;
            path?: never;
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VehicleSummary"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_vehicle: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VehicleState"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    abort_landing: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": {
                    /**
                     * Format: double
                     * @description Height to climb to, metres above home, 1 to 10,000; the vehicle's own when absent, as it has to be for a PX4.
                     */
                    alt_rel_home_m?: number | null;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    altitude: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description What `alt_m` is counted from. */
                    alt_frame: components["schemas"]["AltFrame"];
                    /**
                     * Format: double
                     * @description Height, counted as `alt_frame` says; not 0, which ArduPlane takes for none.
                     */
                    alt_m: number;
                    /** @description As for `goto`. */
                    below_home?: boolean;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    arm: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": {
                    /** @description In spite of the vehicle's own checks (magic number 21196). A PX4 runs them all the same. */
                    force?: boolean;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    climb: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description What `alt_m` is counted from. */
                    alt_frame: components["schemas"]["AltFrame"];
                    /**
                     * Format: double
                     * @description Height, counted as `alt_frame` says; ArduPlane takes neither 0 nor −1.
                     */
                    alt_m: number;
                    /** @description As for `goto`. */
                    below_home?: boolean;
                    /**
                     * Format: double
                     * @description How fast, up or down, 0.01 to 50; as fast as it can when absent. Since 4.7 an ArduPlane hardly climbs at a
                     *     rate: its target is its present height and the climb of a tenth of a second
                     *     (`ModeGuided::update_target_altitude`).
                     */
                    rate_m_s?: number | null;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    command_int: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RawCommandInt"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Acknowledged"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    command_long: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["RawCommandLong"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Acknowledged"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    keep_vehicle_control: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": components["schemas"]["DeclinedRequest"] | null;
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VehicleControl"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    release_vehicle_control: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VehicleControl"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    request_vehicle_control: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VehicleControl"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    course: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /**
                     * Format: double
                     * @description Centripetal acceleration of the turn at most, 0.05 to 20; 5, a bank of 27 degrees, when absent.
                     */
                    accel_m_s2?: number;
                    /**
                     * Format: double
                     * @description Course over ground, degrees from true north, 0 to below 360.
                     */
                    course_deg: number;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    disarm: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": {
                    /** @description Even while flying. */
                    force?: boolean;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    goto: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description Reference of `alt_m`. */
                    alt_frame: components["schemas"]["AltFrame"];
                    /**
                     * Format: double
                     * @description Height, counted as `alt_frame` says; above home or terrain not 0, which ArduPilot takes for none.
                     */
                    alt_m: number;
                    /**
                     * @description Whether an altitude more than 20 m below home is meant, or below the ground that the vehicle reports
                     *     (TERRAIN_REPORT; for a position up to 500 m away); refused when absent. A plane that flies into a valley.
                     */
                    below_home?: boolean;
                    /** @description Whether to enter GUIDED for it, which it does when absent; without it a vehicle in another mode refuses. */
                    change_mode?: boolean;
                    /** @description Sense of the circle; clockwise when absent. */
                    clockwise?: boolean;
                    /**
                     * Format: double
                     * @description WGS-84 latitude.
                     */
                    lat_deg: number;
                    /**
                     * Format: double
                     * @description WGS-84 longitude.
                     */
                    lon_deg: number;
                    /**
                     * Format: double
                     * @description Radius of the circle, 1 to 30,000. When absent the vehicle's own, or with an ArduPlane in GUIDED that of the
                     *     go-to before.
                     */
                    radius_m?: number | null;
                    /**
                     * Format: double
                     * @description Speed, 0.1 to 200: of a plane an airspeed, of others over ground. When absent the vehicle's own, or with an
                     *     ArduPlane in GUIDED that of the go-to before.
                     */
                    speed_m_s?: number | null;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    home: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": {
                    /**
                     * Format: double
                     * @description Height above mean sea level.
                     */
                    alt_amsl_m?: number | null;
                    /**
                     * Format: double
                     * @description WGS-84 latitude.
                     */
                    lat_deg?: number | null;
                    /**
                     * Format: double
                     * @description WGS-84 longitude.
                     */
                    lon_deg?: number | null;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    land: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    loiter: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    send_message: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewMessage"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    set_rate_of_named_message: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
                /** @description Such as RAW_IMU, or its number */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["MessageRate"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    request_named_message: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
                /** @description Such as HOME_POSITION, or its number */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RawMessage"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    mission_current: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /**
                     * Format: int32
                     * @description The item, counted from 1.
                     */
                    item: number;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    mission_pause: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    mission_resume: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    mission_start: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": {
                    /**
                     * Format: int32
                     * @description Item to begin with, counted from 1; where the vehicle stands in the mission when absent, with `MIS_RESTART`
                     *     1 its beginning.
                     */
                    from_item?: number | null;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    mode: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description Which: its name, one of the vehicle's `mode_names`, or its number on the wire. */
                    mode: components["schemas"]["ModeChoice"];
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    read_params: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_param: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
                /** @description Up to 16 characters */
                name: string;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Param"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    set_param: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
                /** @description Up to 16 characters */
                name: string;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["NewParam"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Param"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    compare: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Plan"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlanComparison"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    fence_on_board: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlanOnBoard"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    upload_fence: {
        parameters: {
            query?: {
                /** @description `false` uploads it in spite of errors found by the checks. */
                check?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Plan"];
            };
        };
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    clear_fence: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    download_fence: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    mission_on_board: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlanOnBoard"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    upload_mission: {
        parameters: {
            query?: {
                /** @description `false` uploads it in spite of errors found by the checks. */
                check?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Plan"];
            };
        };
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    clear_mission: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    download_mission: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    rally_on_board: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["PlanOnBoard"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    upload_rally: {
        parameters: {
            query?: {
                /** @description `false` uploads it in spite of errors found by the checks. */
                check?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["Plan"];
            };
        };
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    clear_rally: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    download_rally: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            202: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Operation"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    prepare_flight: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    profile: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["VehicleProfile"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    reboot: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    request_message: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description Which: its name in the dialect, such as `"HOME_POSITION"`, or its number. */
                    message: components["schemas"]["MessageChoice"];
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["RawMessage"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    return_to_launch: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    follow_rival: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            204: {
                headers: {
                    [name: string]: unknown;
                };
                content?: never;
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    set_message_rate: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description Which: its name in the dialect, such as `"ATTITUDE"`, or its number. */
                    message: components["schemas"]["MessageChoice"];
                    /**
                     * @description Messages per second, 0.0005 (one in 2,000 s) to 50; `"default"`, or 0, for the vehicle's own rate; `"stop"`
                     *     for none.
                     */
                    rate_hz: components["schemas"]["RateChoice"];
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    get_signing: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SigningInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    change_signing: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": components["schemas"]["ChangeSigning"];
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["SigningInfo"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    speed: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description Which speed. */
                    kind: components["schemas"]["SpeedKind"];
                    /**
                     * Format: double
                     * @description How fast, 0.1 to 200.
                     */
                    speed_m_s: number;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    switch_fence: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /** @description Whether it is to be on. */
                    on: boolean;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    takeoff: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /**
                     * Format: double
                     * @description Height to climb to, metres above home, 1 to 10,000.
                     */
                    alt_rel_home_m: number;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    list_texts: {
        parameters: {
            query?: never;
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: never;
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Text"][];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    texts: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody: {
            content: {
                "application/json": {
                    /**
                     * Format: int32
                     * @description `MAV_SEVERITY`: 0 emergency to 7 debug; 6, info, when absent.
                     */
                    severity?: number;
                    /** @description The text; cut to 500 characters. */
                    text: string;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
    velocity: {
        parameters: {
            query?: {
                /** @description Carry it out although the mission on board may be mixed or lead out of reach */
                despite_mixed_plan?: boolean;
            };
            header?: never;
            path: {
                /** @description The vehicle's id */
                id: number;
            };
            cookie?: never;
        };
        requestBody?: {
            content: {
                "application/json": {
                    /**
                     * Format: double
                     * @description Down, −50 to 50.
                     */
                    down_m_s?: number;
                    /**
                     * Format: double
                     * @description Forward, −50 to 50.
                     */
                    forward_m_s?: number;
                    /**
                     * Format: double
                     * @description To the right, −50 to 50.
                     */
                    right_m_s?: number;
                    /**
                     * Format: double
                     * @description Clockwise seen from above, −10 to 10.
                     */
                    yaw_rate_rad_s?: number;
                };
            };
        };
        responses: {
            200: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/json": components["schemas"]["Done"];
                };
            };
            /** @description What was wrong and what to do */
            default: {
                headers: {
                    [name: string]: unknown;
                };
                content: {
                    "application/problem+json": components["schemas"]["Problem"];
                };
            };
        };
    };
}
