// What reading a plan file had to assume or leave out, and what writing one could not keep, in English, by the server's codes.
export const filesEn = {
  'file.format': 'Format of the file',
  'file.notes': 'About this file',
  'file.removed.mission': 'It holds no mission: that of the draft was removed. Undo brings it back.',
  'file.removed.fence': 'It holds no fence: that of the draft was removed. Undo brings it back.',
  'file.removed.rally': 'It holds no rally points: those of the draft were removed. Undo brings them back.',
  'note.heights-above-sea-level': 'Heights count from mean sea level, as this format has them ({count}).',
  'note.heights-above-terrain': 'Heights count from the ground below, as the file says ({count}).',
  'note.heights-taken-above-sea-level':
    'Heights were taken as above sea level. The format counts them from the ellipsoid, tens of metres away in places: compare one that you know ({count}).',
  'note.heights-taken-above-home':
    'Heights were taken as above home: the file does not say what they count from ({count}).',
  'note.heights-missing': 'Places have no height: give them one before you send ({count}).',
  'note.not-places': 'Entries that are no places were left out ({count}).',
  'note.points-left-out': 'Points beside the route were left out ({count}).',
  'note.tracks-left-out': 'Tracks beside the route were left out ({count}).',
  'note.items-missing': 'Items that the plan had when it was written are no longer in the file ({count}).',
  'note.items-renumbered':
    'Indices of the file are not in sequence; its items were numbered anew, in the order of the rows ({count}).',
  'note.items-elsewhere':
    'Complex items are of a kind that only their program can lay out, and stand as USER_1, which no vehicle takes. Send the plan from QGroundControl to a vehicle or a simulator, read it back there and save that ({count}).',
  'note.lines-joined': 'Lines were joined to one mission, in the order of the file ({count}).',
  'note.areas-taken-as-fence': 'Areas were taken as zones to stay inside ({count}).',
  'note.holes-taken-as-fence': 'Holes in areas were taken as zones to stay outside ({count}).',
  'note.area-heights-not-kept': 'Areas have heights, which were not kept: a fence has none ({count}).',
  'note.names-not-kept': 'Names and descriptions were not kept: a plan has none ({count}).',
  'note.rally-landings-not-kept':
    'Rally points have a break altitude, a landing direction or flags, which were not kept: a vehicle circles at one, and lands where its mission says ({count}).',
  'note.heights-written-above-sea-level':
    'Heights above home were written as above sea level, by the height of the planned home ({count}).',
  'note.heights-not-written':
    'Heights were not written: the format counts them from the sea, the plan from the ground or from a home that it does not have ({count}).',
  'note.heights-drawn-above-sea-level':
    'Heights above home are drawn above sea level, by the height of the planned home; the data in the file keep them as they are ({count}).',
  'note.heights-not-drawn': 'Heights are not drawn; the data in the file keep them as they are ({count}).',
  'note.commands-not-written': 'Items are more than waypoints: their place and height alone were written ({count}).',
  'note.items-not-written': 'Items without a place were not written ({count}).',
  'note.home-not-written': 'The planned home was not written ({count}).',
  'note.fence-not-written': 'Parts of the fence were not written ({count}).',
  'note.rally-not-written': 'Rally points were not written ({count}).',
  'note.complex-items-edited':
    'Surveys, landing patterns or other complex items were changed, and are written item by item ({count}).',
  'note.settings-not-written': 'Settings beside the plan (speeds, kind of vehicle) were not written ({count}).',
} as const;
