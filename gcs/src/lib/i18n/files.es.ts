// What reading and writing plan files has to say, in Spanish.
import type { filesEn } from './files.en';

export const filesEs: Record<keyof typeof filesEn, string> = {
  'file.format': 'Formato del fichero',
  'file.notes': 'Sobre este fichero',
  'file.removed.mission': 'No tiene misión: se ha quitado la del borrador. Deshacer la recupera.',
  'file.removed.fence': 'No tiene geovalla: se ha quitado la del borrador. Deshacer la recupera.',
  'file.removed.rally': 'No tiene puntos de reunión: se han quitado los del borrador. Deshacer los recupera.',
  'note.heights-above-sea-level': 'Las alturas cuentan desde el nivel del mar, como en este formato ({count}).',
  'note.heights-above-terrain': 'Las alturas cuentan desde el terreno, como dice el fichero ({count}).',
  'note.heights-taken-above-sea-level':
    'Las alturas se han tomado sobre el nivel del mar. El formato las cuenta desde el elipsoide, a decenas de metros en algunos sitios: compara una que conozcas ({count}).',
  'note.heights-taken-above-home':
    'Las alturas se han tomado sobre casa: el fichero no dice desde dónde cuentan ({count}).',
  'note.heights-missing': 'Hay lugares sin altura: dásela antes de enviar ({count}).',
  'note.not-places': 'Se ha dejado fuera lo que no es un lugar ({count}).',
  'note.points-left-out': 'Se han dejado fuera los puntos que no son de la ruta ({count}).',
  'note.tracks-left-out': 'Se han dejado fuera las trazas que no son la ruta ({count}).',
  'note.items-missing': 'Hay puntos que el plan tenía al escribirlo y que ya no están en el fichero ({count}).',
  'note.items-renumbered':
    'Los índices del fichero no son correlativos; los puntos se han numerado de nuevo, en el orden de las filas ({count}).',
  'note.items-elsewhere':
    'Hay elementos complejos que solo su programa sabe trazar; quedan como USER_1, que ningún vehículo acepta. Envía el plan desde QGroundControl a un vehículo o un simulador, léelo allí de nuevo y guarda eso ({count}).',
  'note.lines-joined': 'Las líneas se han unido en una misión, en el orden del fichero ({count}).',
  'note.areas-taken-as-fence': 'Las áreas se han tomado como zonas en las que quedarse dentro ({count}).',
  'note.holes-taken-as-fence': 'Los huecos de las áreas se han tomado como zonas en las que no entrar ({count}).',
  'note.area-heights-not-kept': 'Hay áreas con alturas, que no se guardan: una geovalla no las tiene ({count}).',
  'note.names-not-kept': 'Los nombres y descripciones no se guardan: un plan no los tiene ({count}).',
  'note.rally-landings-not-kept':
    'Hay puntos de reunión con altura de corte, dirección de aterrizaje o marcas, que no se guardan: un vehículo da vueltas en uno, y aterriza donde diga su misión ({count}).',
  'note.heights-written-above-sea-level':
    'Las alturas sobre casa se han escrito sobre el nivel del mar, con la altura de la casa planeada ({count}).',
  'note.heights-not-written':
    'Hay alturas que no se han escrito: el formato las cuenta desde el mar, y el plan desde el terreno o desde una casa que no tiene ({count}).',
  'note.heights-drawn-above-sea-level':
    'Las alturas sobre casa se dibujan sobre el nivel del mar, con la altura de la casa planeada; los datos del fichero las guardan como son ({count}).',
  'note.heights-not-drawn': 'Las alturas no se dibujan; los datos del fichero las guardan como son ({count}).',
  'note.commands-not-written':
    'Hay puntos que son más que puntos de paso: solo se ha escrito su lugar y su altura ({count}).',
  'note.items-not-written': 'Los puntos sin lugar no se han escrito ({count}).',
  'note.home-not-written': 'La casa planeada no se ha escrito ({count}).',
  'note.fence-not-written': 'Hay partes de la geovalla que no se han escrito ({count}).',
  'note.rally-not-written': 'Los puntos de reunión no se han escrito ({count}).',
  'note.complex-items-edited':
    'Se han cambiado levantamientos, patrones de aterrizaje u otros elementos complejos, y se escriben punto a punto ({count}).',
  'note.settings-not-written': 'Los ajustes del plan (velocidades, tipo de vehículo) no se han escrito ({count}).',
};
