// What remedies change, in English.
export const fixesEn = {
  'fix.do': 'Fix: {change}',
  'fix.set-param': 'set {label} to {value}',
  'fix.delete-item': 'delete item {number}',
  'fix.add-takeoff': 'take off first, to {alt_m}',
  'fix.raise-takeoff': 'climb to {alt_m}',
  'fix.add-landing': 'land at home, course {course_deg}',
  'fix.turn-landing': 'land on course {course_deg}',
  'fix.add-circle': 'circle to {alt_m} before it',
  'fix.raise': 'raise it by {difference_m}, and the item before',
  'fix.move-away': 'move it {distance_m} farther away',
  'fix.set-parameter': 'set {name} to {value} on the vehicle',
} as const;
